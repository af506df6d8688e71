//! Differences to the paper, and how to reproduce the report.

use std::fs;
use std::thread;

use super::markup::{Markup, Table};
use super::part::Choice;
use crate::seeds::Seeds;

/// The paper's choice or omission, the paper's value, ours.
const DIFFERENCES: [[&str; 3]; 11] = [
    [
        "Maps",
        "printed as pictures",
        "shapes of the same kind, drawn from geometry at either size; not the same cells",
    ],
    [
        "Sensor",
        "radius and variance not given",
        "radius 5 cells; variance 0.005 (that of NATS and GUTS), growing with distance",
    ],
    ["Found", "from a probability tau on, which is not given", "tau 0.95"],
    [
        "Length of a search",
        "75 decisions",
        "a path of 1000 cells (30 x 30) or 4000 cells (60 x 60): enough for every policy to finish or to stall; F1 keeps its \
         last value once all is found. Areas under F1 are means over that length",
    ],
    ["Length axis", "path length", "cells; an observation is made in every cell entered"],
    [
        "Utility of a path",
        "sum over the path of the expected reduction of entropy (Eq. 3)",
        "the joint information of all observations along the path, as the text around Eq. 3 says; computed exactly",
    ],
    [
        "What a network sees",
        "belief and traversability of each cell",
        "these, the expected gain of an observation from each cell, and the tree of shortest paths as a layer of its own",
    ],
    ["Training", "not given", "behavior cloning with libtorch from Rust; deciding is plain Rust without it"],
    [
        "Seeds",
        "20 trajectories",
        "20 unless asked otherwise, and none that anything was tuned or trained on: that was done with seeds below 1000 and \
         from 100000 on",
    ],
    ["Baselines", "random, coverage", "these, and NATS and GUTS in our implementation"],
    [
        "Field tests",
        "Table III: a vehicle in a forest of 75,000 square meters",
        "driven in simulation: site, trees, detector and speed (2 m/s) are ours; cells of 15.2 m, so that the cone of 30 x 30 \
         cells has the site's area; the configurations A, B and C are not published and ours are others",
    ],
];

/// Seeds that were not used for tuning or training.
const UNSEEN: std::ops::Range<u64> = 1000..100_000;

pub(super) fn differences() -> Markup {
    let mut table = Table::of_words(
        "Where this set-up is not the paper's, or the paper leaves it open.",
        &["what", "in the paper", "here"],
    );
    for row in DIFFERENCES {
        table.row(row.map(str::to_owned).to_vec());
    }
    table.row(vec!["Hardware".to_owned(), "not given".to_owned(), hardware()]);
    Markup::new().table(&table)
}

pub(super) fn reproduction(program: &str, choice: Choice, seeds: Seeds) -> Markup {
    Markup::new()
        .paragraph(&format!(
            "Made by dragnet {program}, the commit in brackets. Scenarios and weights are part of the program, so that this \
             line is all that is needed:"
        ))
        .command(&format!("dragnet paper {} --seeds {} --out DIR", choice.as_str(), String::from(seeds)))
        .paragraph(
            "The same version and seeds give the same numbers on every machine and with any number of threads, but for \
             times. The numbers of each table and figure lie beside this page as CSV files, named after it.",
        )
}

/// A warning about seeds that were used before.
#[must_use]
pub fn warning(seeds: Seeds) -> Option<String> {
    let last = seeds.at(seeds.count() - 1);
    let is_unseen = UNSEEN.contains(&seeds.at(0)) && UNSEEN.contains(&last);
    (!is_unseen).then(|| {
        format!(
            "{seeds}: some of them may have been used to tune or to train, which was done with seeds below {} and from {} on",
            UNSEEN.start, UNSEEN.end
        )
    })
}

fn hardware() -> String {
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let (system, machine) = (std::env::consts::OS, std::env::consts::ARCH);
    format!(
        "{}, {cores} cores, {system} on {machine}",
        processor().unwrap_or_else(|| "a processor".to_owned())
    )
}

/// The processor's name, if the system provides it.
fn processor() -> Option<String> {
    let text = fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_that_were_used_before_are_warned_of() {
        let warns = |seeds: &str| warning(seeds.parse().unwrap()).is_some();
        assert!(!warns("1000..1020") && !warns("5000..5001"));
        assert!(warns("20") && warns("999..1010") && warns("99999..100001") && warns("200000..200001"));
    }
}
