//! The map of a completed search, drawn in characters.

use console::{Color, Style};
use dragnet_search::belief::Belief;
use dragnet_search::cell::{Cell, Grid, Position};
use dragnet_search::measures::Truth;
use dragnet_search::reach::Reach;
use dragnet_search::terrain::Terrain;

/// The contents of a map.
pub(crate) struct Picture<'a> {
    /// The ground.
    pub(crate) terrain: &'a Terrain,
    /// The belief from all readings.
    pub(crate) belief: &'a Belief,
    /// Where the objects are.
    pub(crate) truth: &'a Truth,
    /// The cells that robots can observe.
    pub(crate) reach: &'a Reach,
    /// Probability from which a cell counts as found.
    pub(crate) detection_threshold: f64,
    /// Cells that each robot was in, in order; robots by number.
    pub(crate) tracks: &'a [Vec<Cell>],
}

/// The mark of one character; if it covers several cells, the greatest of theirs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Mark {
    /// Neither traversable nor searched.
    Blocked,
    /// Traversable, not searched.
    Passage,
    /// Searched, and out of reach of all robots.
    OutOfReach,
    /// The evidence against an object is as strong as the detection threshold requires for one.
    Cleared,
    Unknown,
    /// A robot's track, by its number.
    Track(usize),
    /// Where a robot is at the end.
    Robot,
    Found,
    FalsePositive,
    Missed,
}

const LEGEND: [Mark; 10] = [
    Mark::Found,
    Mark::Missed,
    Mark::FalsePositive,
    Mark::Unknown,
    Mark::Cleared,
    Mark::Track(1),
    Mark::Robot,
    Mark::OutOfReach,
    Mark::Passage,
    Mark::Blocked,
];

/// Colors of the robots' tracks, in turn.
const TRACK_COLORS: [Color; 3] = [Color::Cyan, Color::Blue, Color::Magenta];

/// The most lines that a map takes.
const MAX_LINES: u32 = 100;

impl Picture<'_> {
    /// The map in at most this many columns, the northern edge first, with row and column numbers and a legend. Larger
    /// maps are drawn at a coarser scale.
    pub(crate) fn draw(&self, columns: usize) -> String {
        let marks = self.marks();
        let grid = self.terrain.grid();
        let scale = Scale::of(grid, columns);
        let lines = (0..grid.rows().div_ceil(scale.rows)).rev();
        let mut text: String = lines.map(|line| scale.line(grid, &marks, line * scale.rows)).collect();
        text += &scale.column_numbers(grid);
        text += &legend(&marks, scale.margin, columns);
        text
    }

    /// Shape `[cells]`.
    fn marks(&self) -> Vec<Mark> {
        let mut marks: Vec<Mark> = self.terrain.grid().cells().map(|cell| self.believed(cell)).collect();
        let mut raise = |cell: Cell, mark: Mark| marks[cell.index()] = marks[cell.index()].max(mark);
        for (robot, track) in (1..).zip(self.tracks) {
            for &cell in track {
                raise(cell, Mark::Track(robot));
            }
            if let Some(&last) = track.last() {
                raise(last, Mark::Robot);
            }
        }
        marks
    }

    fn believed(&self, cell: Cell) -> Mark {
        let ground = self.terrain.ground(cell);
        if !ground.searched {
            return if ground.traversable { Mark::Passage } else { Mark::Blocked };
        }
        let against_nats = -self.belief.evidence().of(cell).log_likelihood_ratio_nats();
        let is_cleared = against_nats >= (self.detection_threshold / (1.0 - self.detection_threshold)).ln();
        match (self.belief.is_found(cell, self.detection_threshold), self.truth.is_object(cell)) {
            (true, true) => Mark::Found,
            (true, false) => Mark::FalsePositive,
            (false, true) => Mark::Missed,
            (false, false) if !self.reach.covers(cell) => Mark::OutOfReach,
            (false, false) if is_cleared => Mark::Cleared,
            (false, false) => Mark::Unknown,
        }
    }
}

/// Cells per character. A character is about twice as high as wide.
struct Scale {
    rows: u32,
    columns: u32,
    /// Whether a cell takes two characters, one of them a space, so that it is about square.
    is_wide: bool,
    /// Characters of the row numbers and the space after them.
    margin: usize,
}

impl Scale {
    fn of(grid: Grid, columns: usize) -> Self {
        let margin = grid.rows().to_string().len().max(4) + 1;
        let width = u32::try_from(columns.saturating_sub(margin).max(1)).unwrap_or(u32::MAX);
        if grid.columns() <= width / 2 && grid.rows() <= MAX_LINES {
            return Self { rows: 1, columns: 1, is_wide: true, margin };
        }
        let columns = grid.columns().div_ceil(width).max(grid.rows().div_ceil(2 * MAX_LINES));
        Self { rows: 2 * columns, columns, is_wide: false, margin }
    }

    /// One line, from its southernmost row on.
    fn line(&self, grid: Grid, marks: &[Mark], row: u32) -> String {
        let mut line = format!("{row:>width$} ", width = self.margin - 1);
        for column in (0..grid.columns()).step_by(self.columns as usize) {
            line += &self.mark(grid, marks, Position { row, column }).painted();
            if self.is_wide {
                line.push(' ');
            }
        }
        line.truncate(line.trim_end().len());
        line.push('\n');
        line
    }

    /// The greatest mark of the cells of a character, whose south-western cell is `from`.
    fn mark(&self, grid: Grid, marks: &[Mark], from: Position) -> Mark {
        let rows = from.row..from.row + self.rows;
        let columns = from.column..from.column + self.columns;
        let cells = rows.flat_map(|row| columns.clone().map(move |column| Position { row, column }));
        let marks = cells.filter_map(|position| grid.cell(position)).map(|cell| marks[cell.index()]);
        marks.max().unwrap_or(Mark::Blocked)
    }

    /// Numbers below every tenth character.
    fn column_numbers(&self, grid: Grid) -> String {
        let width = if self.is_wide { 20 } else { 10 };
        let last = grid.columns() - 1;
        let numbers = (0..=last).step_by(10 * self.columns as usize);
        let numbers: Vec<String> = numbers.map(|column| format!("{column:<width$}")).collect();
        format!("{:margin$}{}\n", "", numbers.concat().trim_end(), margin = self.margin)
    }
}

/// The meaning of the marks that occur on this map.
fn legend(marks: &[Mark], margin: usize, columns: usize) -> String {
    let is_shown = |entry: &Mark| marks.iter().any(|mark| mark.same_kind(*entry));
    let mut lines: Vec<String> = Vec::new();
    let mut used = columns;
    for entry in LEGEND.into_iter().filter(is_shown) {
        let width = "*   ".len() + entry.meaning().len();
        if used + width > columns {
            lines.push(" ".repeat(margin));
            used = margin;
        }
        used += width;
        if let Some(line) = lines.last_mut() {
            line.extend([&entry.painted(), " ", entry.meaning(), "  "]);
        }
    }
    lines.iter().map(|line| line.trim_end().to_owned() + "\n").collect()
}

impl Mark {
    fn same_kind(self, other: Self) -> bool {
        std::mem::discriminant(&self) == std::mem::discriminant(&other)
    }

    fn meaning(self) -> &'static str {
        match self {
            Self::Blocked => "blocked",
            Self::Passage => "not searched",
            Self::OutOfReach => "out of reach",
            Self::Cleared => "cleared",
            Self::Unknown => "unknown",
            Self::Track(_) => "track of robot 1 and so on",
            Self::Robot => "robot at the end",
            Self::Found => "found",
            Self::FalsePositive => "false positive",
            Self::Missed => "missed",
        }
    }

    fn character(self) -> char {
        match self {
            Self::Blocked => '#',
            Self::Passage => '_',
            Self::OutOfReach => '~',
            Self::Cleared => '.',
            Self::Unknown => '?',
            Self::Track(robot) => char::from_digit(u32::try_from(robot % 10).unwrap_or(0), 10).unwrap_or('0'),
            Self::Robot => '@',
            Self::Found => '*',
            Self::FalsePositive => 'x',
            Self::Missed => '!',
        }
    }

    /// Colored if stdout is a terminal that supports colors.
    fn painted(self) -> String {
        let style = match self {
            Self::Blocked | Self::Passage | Self::OutOfReach | Self::Cleared => Style::new().dim(),
            Self::Unknown => Style::new().yellow(),
            Self::Track(robot) => Style::new().fg(TRACK_COLORS[robot % TRACK_COLORS.len()]),
            Self::Robot => Style::new().bold(),
            Self::Found => Style::new().green().bold(),
            Self::FalsePositive | Self::Missed => Style::new().red().bold(),
        };
        style.apply_to(self.character()).to_string()
    }
}

#[cfg(test)]
mod tests {
    use dragnet_search::evidence::Reading;
    use dragnet_search::reach::Sight;

    use super::*;

    /// The southern row: found, false positive, missed, cleared, unknown, track of robot 2, its end.
    fn picture(drawing: &str, columns: usize) -> String {
        console::set_colors_enabled(false);
        let terrain = Terrain::from_ascii(drawing, 1.0).unwrap();
        let mut belief = Belief::uniform(&terrain, 0.2).unwrap();
        let south: Vec<Cell> = terrain.grid().cells().take(terrain.grid().columns() as usize).collect();
        for (&cell, value) in south.iter().zip([1.0, 1.0, 0.5, 0.0]) {
            belief.add(&Reading { cell, value, variance: 0.01 });
        }
        let truth = Truth::new(&terrain, vec![south[0], south[2]]);
        let tracks = [Vec::new(), vec![south[5], south[6]]];
        let mut reach = Reach::unknown(terrain.grid());
        reach.add_robot(&terrain, Sight::on_ground(3), south[0]);
        let tracks = &tracks;
        Picture {
            terrain: &terrain,
            belief: &belief,
            truth: &truth,
            reach: &reach,
            detection_threshold: 0.95,
            tracks,
        }
        .draw(columns)
    }

    #[test]
    fn each_cell_shows_its_state() {
        let drawn = picture("#,.....\n.......", 80);
        let lines: Vec<&str> = drawn.lines().collect();
        assert_eq!(lines[..3], ["   1 # _ ? ? ? ? ?", "   0 * x ! . ? 2 @", "     0"], "{drawn}");
        assert!(lines[3..].iter().all(|line| line.len() <= 80), "{drawn}");
        for entry in ["* found", "! missed", "x false positive", "? unknown", ". cleared", "# blocked"] {
            assert!(lines[3..].iter().any(|line| line.contains(entry)), "{entry}\n{drawn}");
        }
    }

    #[test]
    fn cells_out_of_reach_are_shown_so() {
        let drawn = picture("~~~~~~~\n~~~~~~~\n~~~~~~~\n~~~~~~~\n~~~~~~~\n.......", 80);
        let lines: Vec<&str> = drawn.lines().collect();
        assert_eq!(lines[..3], ["   5 ~ ~ ~ ~ ~ ~ ~", "   4 ~ ~ ~ ~ ~ ~ ~", "   3 ? ? ? ? ? ? ?"], "{drawn}");
        assert!(drawn.contains("~ out of reach"), "{drawn}");
    }

    #[test]
    fn a_larger_map_is_drawn_at_a_coarser_scale() {
        let drawn = picture("#,.....\n.......", 14);
        assert_eq!(drawn.lines().next(), Some("   0 *x!??2@"), "{drawn}");
        let drawn = picture("#,.....\n.......", 10);
        assert_eq!(drawn.lines().next(), Some("   0 x!2@"), "{drawn}");
    }

    #[test]
    fn no_map_is_larger_than_asked() {
        for (rows, columns) in [(40, 300), (3000, 7)] {
            let drawing = vec![".".repeat(columns); rows].join("\n");
            for width in [40, 79, 80, 200, 610] {
                let drawn = picture(&drawing, width);
                assert!(drawn.lines().count() < 110, "{drawn}");
                assert!(drawn.lines().all(|line| line.trim_end().len() <= width), "{width}\n{drawn}");
            }
        }
    }
}
