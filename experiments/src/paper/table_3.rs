//! Table III: the field test, driven in simulation.
//!
//! Vehicles with cameras search a cone of 75,000 square meters for five objects (`dragnet_sim::field`, which says what
//! is simulated). The paper's configurations A, B and C are not published: ours are three seeds that were fixed before
//! any was run. Since three are few, one more is run for each seed.
//!
//! Decisions take milliseconds here and cost the mission nothing, so that a trial is the same on every machine; the
//! measured times are printed beside. The paper's NATS took 10 to 30 s for each waypoint, which is part of its times:
//! so `nats` is run with these delays too. Its vehicle uses them to drive on to the middle of the waypoint's cell, and
//! stands when it gets there.
//!
//! A trial that is not done after 15 minutes counts as 15 minutes in every speed-up, as in the paper: a speed-up over a
//! `nats` that did not find all objects is a lower bound, that of a policy that did not is an upper bound.

mod trials;

use super::markup::{Markup, Table};
use super::measure;
use super::part::Part;
use super::published::{FIELD_BUDGET_SECONDS, TABLE_3};
use super::section::{Claim, File, Section, Verdict, certain};
use crate::ExperimentError;
use crate::comparison::{Estimate, files};
use crate::progress::Progress;
use crate::seeds::Seeds;
use dragnet_sim::comparison::Latencies;
use trials::{CONTENDERS, Contender, Trials};

/// The speed-up over `nats` that the claim requires.
const TARGET: f64 = 1.3;

pub(super) fn section(
    seeds: Seeds,
    threads: Option<u16>,
    progress: &dyn Progress,
) -> Result<Section, ExperimentError> {
    let trials = trials::run(seeds, threads, progress)?;
    Ok(Section {
        part: Part::Table3,
        title: "Field test, in simulation",
        body: Markup::new()
            .paragraph(
                "A ground vehicle with the paper's two cameras on a turning head searches a cone of 74,857 square meters for five \
                 things, for 15 minutes at most, at 2 m/s. The whole chain is in the loop: boxes of a detector that misses \
                 and imagines things, tracks, evidence, belief, policy, route, plan on the lattice, motion. Paper and program \
                 differ in site, trees, speed and detector, so that times compare within a column only.",
            )
            .table(&configurations(&trials))
            .table(&times(&trials))
            .table(&speedups(&trials))
            .paragraph(&deciding(&trials)),
        claims: vec![sooner(&trials), path_clone(&trials)],
        files: vec![File { name: "table-3.csv".to_owned(), content: csv(&trials).map_err(ExperimentError::run)? }],
    })
}

/// `05:15`, or `>15:00`.
fn minutes(seconds: f64) -> String {
    if seconds >= FIELD_BUDGET_SECONDS {
        return ">15:00".to_owned();
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 900")]
    let whole = seconds.round() as u32;
    format!("{:02}:{:02}", whole / 60, whole % 60)
}

fn configurations(trials: &Trials) -> Table {
    let mut table = Table::of_numbers(
        "Time to find all five, minutes and seconds, and how many times as fast as NATS: in our configurations A, B and C, and \
         in the paper's of these names.",
        &["", "A", "B", "C", "speed-up, A", "speed-up, B", "speed-up, C"],
    );
    let line = |name: &str, times: &[f64], speedups: &[f64]| {
        let speedups = speedups.iter().map(|speedup| format!("{speedup:.2}"));
        let cells = times.iter().map(|&time| minutes(time)).chain(speedups);
        std::iter::once(name.to_owned()).chain(cells).collect()
    };
    for contender in &CONTENDERS {
        table.group(&contender.title());
        table.row(line("here", &trials.configurations(contender), &named_speedups(trials, contender)));
        if let Some(row) = contender.in_paper() {
            table.row(line("paper", &TABLE_3[row].seconds, &TABLE_3[row].speedups));
        }
    }
    table
}

/// Speed-ups over a `nats` whose decisions take no time, in the named configurations.
fn named_speedups(trials: &Trials, contender: &Contender) -> Vec<f64> {
    let pairs = trials.configurations(contender).into_iter().zip(trials.configurations(&CONTENDERS[0]));
    pairs.map(|(time, nats)| nats / time).collect()
}

fn times(trials: &Trials) -> Table {
    let caption = format!(
        "Over {} random configurations: in how many all five were found in time, and when. Quartiles are over \
         configurations; what was not found in time counts as 15 minutes.",
        trials.count()
    );
    let titles = ["", "found all", "first quartile", "median", "third quartile", "false finds", "path, m"];
    let mut table = Table::of_numbers(&caption, &titles);
    for contender in &CONTENDERS {
        let times = trials.random(contender);
        let [first, median, third] = quartiles(&times);
        let found = times.iter().filter(|&&time| time < FIELD_BUDGET_SECONDS).count();
        table.row(vec![
            contender.title(),
            format!("{found} of {}", times.len()),
            minutes(first),
            minutes(median),
            minutes(third),
            format!("{:.2}", trials.mean_false_finds(contender)),
            format!("{:.0}", quartiles(&trials.paths(contender))[1]),
        ]);
    }
    table
}

/// The speed-up of a contender over another, seed by seed.
fn ratios(trials: &Trials, contender: &Contender, over: &Contender) -> Vec<f64> {
    let pairs = trials.random(contender).into_iter().zip(trials.random(over));
    pairs.map(|(time, over)| over / time).collect()
}

fn speedups(trials: &Trials) -> Table {
    let caption = format!(
        "How many times as fast as `nats`, configuration by configuration: median over {} random configurations, and the \
         quartiles. In the columns to the right NATS takes the paper's time for each waypoint, the others none.",
        trials.count()
    );
    let over: Vec<&Contender> = CONTENDERS.iter().filter(|contender| contender.is_nats()).collect();
    let heads: Vec<String> = over.iter().map(|nats| format!("over {}", nats.title())).collect();
    let titles: Vec<&str> = std::iter::once("").chain(heads.iter().map(String::as_str)).collect();
    let mut table = Table::of_numbers(&caption, &titles);
    for contender in CONTENDERS.iter().filter(|contender| !contender.is_nats()) {
        let cells = over.iter().map(|nats| spread(&ratios(trials, contender, nats)));
        table.row(std::iter::once(contender.title()).chain(cells).collect());
    }
    table
}

/// `1.42 (1.01 to 1.96)`
fn spread(values: &[f64]) -> String {
    let [first, median, third] = quartiles(values);
    format!("{median:.2} ({first:.2} to {third:.2})")
}

/// First quartile, median and third quartile, linearly interpolated; of at least one value.
fn quartiles(values: &[f64]) -> [f64; 3] {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    [0.25, 0.5, 0.75].map(|share| {
        let place = share * (sorted.len() - 1) as f64;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a place in the list")]
        let before = place.floor() as usize;
        let after = (before + 1).min(sorted.len() - 1);
        sorted[before] + (sorted[after] - sorted[before]) * (place - place.floor())
    })
}

fn deciding(trials: &Trials) -> String {
    let mut texts = Vec::new();
    for contender in CONTENDERS.iter().filter(|contender| contender.thinking_seconds == 0) {
        let latencies = Latencies::new(trials.decisions(contender));
        let percentile = |percent| latencies.percentile_ms(percent).unwrap_or(f64::NAN);
        texts.push(format!("{} {:.2} ms ({:.2} ms)", contender.title(), percentile(50), percentile(99)));
    }
    format!(
        "Time of a decision as measured while this was run, the median and what 99 % took no longer than: {}. On the mission's \
         clock a decision takes no time, or that of its row.",
        texts.join("; ")
    )
}

fn clones() -> impl Iterator<Item = &'static Contender> {
    CONTENDERS.iter().filter(|contender| !contender.is_nats() && contender.in_paper().is_some())
}

fn sooner(trials: &Trials) -> Claim {
    let speedups = |clone| named_speedups(trials, clone);
    let texts = clones().map(|clone| {
        let all: Vec<String> = speedups(clone).iter().map(|speedup| format!("{speedup:.2}")).collect();
        format!("{} {}", clone.title(), all.join(", "))
    });
    let margins: Vec<Estimate> = clones().flat_map(speedups).map(|speedup| certain(speedup - 1.0)).collect();
    Claim {
        part: Part::Table3,
        paper: "In each of the configurations A, B and C every clone finds all five sooner than NATS, 1.10 to 2.86 times as fast.",
        here: format!(
            "Times as fast as `nats` in our A, B and C, no decision taking any time: {}.",
            texts.collect::<Vec<_>>().join("; ")
        ),
        verdict: Verdict::of(&margins),
    }
}

fn path_clone(trials: &Trials) -> Claim {
    let [nats, slow] = [0, 30].map(Contender::nats);
    let clone = CONTENDERS.iter().find(|contender| contender.in_paper() == Some(3)).unwrap_or(&CONTENDERS[0]);
    let at_once = ratios(trials, clone, &nats);
    let [_, median, _] = quartiles(&at_once);
    let reached = if median >= TARGET { "at least" } else { "less than" };
    Claim {
        part: Part::Table3,
        paper: "The clone of path-integral search is faster than NATS in every configuration, 1.63 to 2.64 times as fast.",
        here: format!(
            "Over {} random configurations {} is {} times as fast as `nats` in the median (and its quartiles), {reached} {TARGET}, if \
             no decision takes any time; {} times if NATS takes 30 s for each waypoint. The verdict is on the mean of the logarithms of \
             the former, {}.",
            trials.count(),
            clone.title(),
            spread(&at_once),
            spread(&ratios(trials, clone, &slow)),
            measure::signed(log_speedup(&at_once), 3),
        ),
        verdict: Verdict::of(&[log_speedup(&at_once)]),
    }
}

fn log_speedup(ratios: &[f64]) -> Estimate {
    Estimate::of(ratios.iter().map(|ratio| ratio.ln()))
}

fn csv(trials: &Trials) -> Result<Vec<u8>, csv::Error> {
    files::table(trials::TITLES, |writer| trials.lines().try_for_each(|line| writer.serialize(line)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quartiles_lie_between_values() {
        for (values, expected) in [
            (&[3.0] as &[f64], "3.00 (3.00 to 3.00)"),
            (&[4.0, 1.0, 3.0, 2.0, 5.0], "3.00 (2.00 to 4.00)"),
            (&[1.0, 2.0], "1.50 (1.25 to 1.75)"),
        ] {
            assert_eq!(spread(values), expected);
        }
    }

    #[test]
    fn times_are_minutes_and_seconds() {
        assert_eq!(minutes(315.4), "05:15");
        assert_eq!(minutes(899.6), "15:00");
        assert_eq!(minutes(900.0), ">15:00");
    }

    #[test]
    fn the_configurations_are_none_that_were_used_before() {
        assert!(trials::CONFIGURATIONS.iter().all(|(_, seed)| (1000..100_000).contains(seed)));
    }
}
