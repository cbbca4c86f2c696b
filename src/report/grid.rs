//! Tables for a terminal.

use super::figures::plain;

/// Columns of a terminal that a table takes at most.
pub const WIDTH: usize = 110;

/// A cell is cut to this many characters; no number has as many.
const CELL_WIDTH: usize = 28;

const GAP: &str = "  ";

/// Cells by row; what is no name stands to the right of its column.
pub struct Grid {
    /// Lines of the head.
    pub head: Vec<Vec<String>>,
    /// Columns at the left that hold names.
    pub n_names: usize,
    pub rows: Vec<Vec<String>>,
}

impl Grid {
    /// The table. Columns that do not fit stand in further blocks, each with the names.
    pub fn text(&self) -> String {
        let all = || self.head.iter().chain(&self.rows);
        let n_columns = all().map(Vec::len).max().unwrap_or(0);
        let cell = |row: &[String], column: usize| {
            shortened(&plain(row.get(column).map_or("", String::as_str)))
        };
        let width = |column: usize| all().map(|row| length(&cell(row, column))).max().unwrap_or(0);
        let widths: Vec<usize> = (0..n_columns).map(width).collect();
        let names: Vec<usize> = (0..self.n_names.min(n_columns)).collect();
        let mut blocks = Vec::new();
        let mut columns = names.clone();
        for column in self.n_names..n_columns {
            let taken: usize = columns.iter().map(|&c| widths[c] + GAP.len()).sum();
            if columns.len() > names.len() && taken + widths[column] > WIDTH {
                blocks.push(std::mem::replace(&mut columns, names.clone()));
            }
            columns.push(column);
        }
        blocks.push(columns);
        let line = |row: &Vec<String>, columns: &[usize]| {
            let padded = columns.iter().map(|&column| {
                let text = cell(row, column);
                let blank = " ".repeat(widths[column].saturating_sub(length(&text)));
                if column < self.n_names { text + &blank } else { blank + &text }
            });
            let line = padded.collect::<Vec<_>>().join(GAP);
            format!("{}\n", line.trim_end())
        };
        let block =
            |columns: &Vec<usize>| all().map(|row| line(row, columns)).collect::<Vec<_>>().concat();
        blocks.iter().map(block).collect::<Vec<_>>().join("\n")
    }
}

fn length(text: &str) -> usize {
    text.chars().count()
}

fn shortened(name: &str) -> String {
    match length(name) > CELL_WIDTH {
        true => name.chars().take(CELL_WIDTH - 1).chain(['…']).collect(),
        false => name.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_stand_below_each_other_and_break_where_they_must() {
        let row = |name: &str, number: &str| {
            [vec![name.to_string()], vec![number.to_string(); 12]].concat()
        };
        let rows = vec![row("a", "1.5"), row(&"long ".repeat(10), "123456789")];
        let text = Grid { head: vec![row("name", "x")], n_names: 1, rows }.text();
        assert!(text.lines().all(|line| length(line) <= WIDTH), "{text}");
        let blocks: Vec<Vec<&str>> =
            text.split("\n\n").map(|block| block.lines().collect()).collect();
        assert!(blocks.len() == 2 && blocks.iter().all(|block| block.len() == 3), "{text}");
        assert!(blocks.iter().all(|block| block[1].starts_with("a ")), "{text}");
        assert_eq!(text.matches("1.5").count(), 12);
        assert_eq!(length(blocks[0][0]), length(blocks[0][2]), "{text}");
    }
}
