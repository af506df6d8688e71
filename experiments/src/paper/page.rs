//! The report as one self-contained page: no script, no network, no other file.

use super::markup::{Markup, Table, escape};
use super::part::Choice;
use super::section::{Claim, Section, Verdict};
use super::setup;
use crate::seeds::Seeds;

/// The contents of the page.
pub(super) struct Page<'a> {
    /// Version and commit.
    pub(super) program: &'a str,
    pub(super) choice: Choice,
    pub(super) seeds: Seeds,
    pub(super) sections: &'a [Section],
}

const TITLE: &str = "Efficient Active Search via Amortized Path-Integral Policies, repeated";

const SUMMARY: &str = "What holds";

const STYLE: &str = include_str!("page.css");

impl Page<'_> {
    pub(super) fn draw(&self) -> String {
        let mut main = heading(self.program, self.seeds);
        main += &self.contents();
        if self.has_claims() {
            main += &section("summary", SUMMARY, &self.summary());
        }
        for Section { part, title, body, .. } in self.sections {
            main += &section(part.as_str(), &part.heading(title), body);
        }
        main += &section("differences", "Differences from the paper's set-up", &setup::differences());
        let reproduction = setup::reproduction(self.program, self.choice, self.seeds);
        main += &section("reproduction", "How to make this report again", &reproduction);
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>{TITLE}</title>\n\
             <style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n{main}</main>\n</body>\n</html>\n"
        )
    }

    fn contents(&self) -> String {
        let mut entries = Vec::new();
        if self.has_claims() {
            entries.push(entry("summary", SUMMARY));
        }
        for Section { part, title, .. } in self.sections {
            entries.push(entry(part.as_str(), &part.heading(title)));
        }
        entries.push(entry("differences", "Differences from the paper's set-up"));
        entries.push(entry("reproduction", "How to make this report again"));
        format!("<nav aria-label=\"Contents\">\n<ol>\n{}</ol>\n</nav>\n", entries.concat())
    }

    /// Whether a section repeats a claim of the paper.
    fn has_claims(&self) -> bool {
        self.sections.iter().any(|section| !section.claims.is_empty())
    }

    fn summary(&self) -> Markup {
        let claims: Vec<&Claim> = self.sections.iter().flat_map(|section| &section.claims).collect();
        let holding = claims.iter().filter(|claim| claim.verdict.holds()).count();
        let mut table = Table::of_words(
            "Claims of the paper, each with what was measured here. Whether it holds is computed from the means; chance \
             could explain it where two standard errors could turn that. Differences are taken seed by seed.",
            &["the paper says", "measured here"],
        );
        for of_part in claims.chunk_by(|a, b| a.part == b.part) {
            table.group(of_part[0].part.in_paper());
            for claim in of_part {
                table.row(vec![claim.paper.to_owned(), format!("{}. {}", claim.verdict, claim.here)]);
            }
        }
        let barely = match claims.iter().filter(|claim| claim.verdict == Verdict::HoldsBarely).count() {
            0 => String::new(),
            count => format!(", {count} of them by so little that chance could explain it"),
        };
        let sum = format!(
            "{holding} of {} claims hold{barely}. Where a clone is better here, or an expert cheaper, than the paper has it, its \
             claim does not hold either.",
            claims.len()
        );
        Markup::new().paragraph(&sum).table(&table)
    }
}

fn heading(program: &str, seeds: Seeds) -> String {
    let about = format!(
        "The simulated experiments of the paper of this name, run again by dragnet {program} with {seeds}, beside the paper's \
         own figures."
    );
    let warning =
        setup::warning(seeds).map_or_else(Markup::new, |text| Markup::new().paragraph(&format!("{text}.")));
    let about = Markup::new().paragraph(&about).then(&warning);
    format!("<h1>{TITLE}</h1>\n{}", about.as_str())
}

fn section(id: &str, title: &str, body: &Markup) -> String {
    format!("<section id=\"{id}\">\n<h2>{}</h2>\n{}</section>\n", escape(title), body.as_str())
}

fn entry(id: &str, title: &str) -> String {
    format!("<li><a href=\"#{id}\">{}</a></li>\n", escape(title))
}
