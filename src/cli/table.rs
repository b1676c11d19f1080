//! A table of measurements that goes to a file, to a page and to the terminal.
//!
//! A number is kept whole, with the decimals that people want to see. [`Table::csv`] writes it whole, so that others
//! can go on from there; the page ([`Page::table`](super::report_page::Page::table)) and [`Table::text`] round it.

/// Headers and rows. A row may be shorter than another: what it lacks is missing.
#[derive(Debug, Clone, Default)]
pub struct Table {
    headers: Vec<String>,
    rows: Vec<Vec<Cell>>,
}

/// What a cell holds.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// Words.
    Text(String),
    /// A number, and how many decimals people see of it.
    Number(f64, usize),
    /// Nothing was measured.
    Missing,
}

impl Table {
    /// A table without rows.
    pub fn new<S: Into<String>>(headers: impl IntoIterator<Item = S>) -> Self {
        Table { headers: headers.into_iter().map(Into::into).collect(), rows: Vec::new() }
    }

    /// Adds a row; its first cell names it.
    pub fn row(&mut self, cells: impl IntoIterator<Item = Cell>) {
        self.rows.push(cells.into_iter().collect());
    }

    /// The headers, one for each column.
    pub fn headers(&self) -> Vec<&str> {
        let headers = self.headers.iter().map(String::as_str).chain(std::iter::repeat(""));
        headers.take(self.columns()).collect()
    }

    /// The rows, each with a cell for each column.
    pub fn rows(&self) -> impl Iterator<Item = Vec<&Cell>> {
        let columns = self.columns();
        self.rows.iter().map(move |row| row.iter().chain(std::iter::repeat(&Cell::Missing)).take(columns).collect())
    }

    /// The table as a file of comma-separated values (RFC 4180, but with the line ends of Unix).
    pub fn csv(&self) -> String {
        let headers = self.headers().into_iter().map(quoted).collect();
        let rows = self.rows().map(|row| row.into_iter().map(Cell::csv).collect());
        let lines = std::iter::once(headers).chain(rows).map(|cells: Vec<String>| cells.join(",") + "\n");
        lines.collect()
    }

    /// The table for a terminal: words to the left of their columns, numbers to the right.
    pub fn text(&self) -> String {
        let headers = self.headers().into_iter().map(on_one_line).collect();
        let rows = self.rows().map(|row| row.into_iter().map(|cell| on_one_line(&cell.shown())).collect());
        let lines: Vec<Vec<String>> = std::iter::once(headers).chain(rows).collect();
        let width = |column: usize| lines.iter().map(|line| line[column].chars().count()).max().unwrap_or(0);
        let columns: Vec<(usize, bool)> =
            (0..self.columns()).map(|column| (width(column), self.is_words(column))).collect();
        let padded = |line: &Vec<String>| {
            let cells = line.iter().zip(&columns).map(|(text, &(width, words))| match words {
                true => format!("{text:<width$}"),
                false => format!("{text:>width$}"),
            });
            cells.collect::<Vec<_>>().join("  ").trim_end().to_owned() + "\n"
        };
        lines.iter().map(padded).collect()
    }

    /// Whether a column holds words, to be read from the left, and not only numbers.
    pub fn is_words(&self, column: usize) -> bool {
        self.rows.iter().any(|row| matches!(row.get(column), Some(Cell::Text(_))))
    }

    fn columns(&self) -> usize {
        self.rows.iter().map(Vec::len).fold(self.headers.len(), usize::max)
    }
}

impl Cell {
    /// What a person reads.
    pub fn shown(&self) -> String {
        match self {
            Cell::Text(text) => text.clone(),
            Cell::Number(number, decimals) => format!("{number:.decimals$}"),
            Cell::Missing => "-".to_owned(),
        }
    }

    fn csv(&self) -> String {
        match self {
            Cell::Text(text) => quoted(text),
            Cell::Number(number, _) => number.to_string(),
            Cell::Missing => String::new(),
        }
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Cell::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Cell::Text(text)
    }
}

/// A field of a CSV file. Quotes are set around what would be read as something else, and doubled within.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) || text.trim() != text {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

/// Text for one line of a terminal, which a name from outside must neither break nor steer.
pub fn on_one_line(text: &str) -> String {
    text.replace(char::is_control, " ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> Table {
        let mut table = Table::new(["paint", "error", "frames"]);
        table.row(["red, \"dark\"".into(), Cell::Number(1.0 / 3.0, 3), Cell::Number(12.0, 0)]);
        table.row(["green\nand yellow".into(), Cell::Missing]);
        table
    }

    #[test]
    fn a_file_quotes_what_needs_it_and_keeps_numbers_whole() {
        let expected = "paint,error,frames\n\"red, \"\"dark\"\"\",0.3333333333333333,12\n\"green\nand yellow\",,\n";
        assert_eq!(example().csv(), expected);
        assert_eq!(quoted(" a"), "\" a\"");
        assert_eq!(quoted("a b"), "a b");
    }

    #[test]
    fn columns_on_the_terminal_are_aligned() {
        let mut table = Table::new(["paint", "error"]);
        table.row(["rouge foncé".into(), Cell::Number(10.25, 2), "without\na header".into()]);
        table.row(["grün".into(), Cell::Number(-0.5, 2)]);
        let expected = "paint        error\n\
                        rouge foncé  10.25  without a header\n\
                        grün         -0.50  -\n";
        assert_eq!(table.text(), expected);
    }

    #[test]
    fn a_table_without_rows_is_its_headers() {
        assert_eq!(Table::new(["a", "b"]).csv(), "a,b\n");
        assert_eq!(Table::new(["a", "b"]).text(), "a  b\n");
    }
}
