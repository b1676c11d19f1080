//! `blocks.json`: what a quilting chose, for those who want to look inside.

use super::quilting::Quilting;
use impasto::synthesis::params::BlockRecord;

/// The file's text: parameters, then one line per placed block in placing order.
pub fn json(quilting: &Quilting, blocks: &[BlockRecord]) -> String {
    let Quilting { block, overlap, tolerance, seed, .. } = quilting;
    let lines: Vec<String> = blocks.iter().map(line).collect();
    format!(
        "{{\"block\":{block},\"overlap\":{overlap},\"tolerance\":{tolerance},\"seed\":{seed},\"blocks\":[\n{}\n]}}\n",
        lines.join(",\n")
    )
}

fn line(record: &BlockRecord) -> String {
    let BlockRecord { row, col, x, y, sx, sy, error, min_error, allowed: [sx0, sy0, sx1, sy1] } = record;
    format!(
        "{{\"row\":{row},\"col\":{col},\"x\":{x},\"y\":{y},\"sx\":{sx},\"sy\":{sy},\
         \"error\":{error},\"min_error\":{min_error},\"allowed\":[{sx0},{sy0},{sx1},{sy1}]}}"
    )
}

#[cfg(test)]
mod tests {
    use super::super::quilting::SearchFlag;
    use super::*;
    use serde_json::{json, Value};

    #[test]
    fn is_json_with_the_promised_names() {
        let quilting = Quilting { block: 32, overlap: 6, tolerance: 0.1, seed: 7, search: SearchFlag::Auto };
        let record =
            BlockRecord { row: 1, col: 2, x: 52, y: 26, sx: 3, sy: 4, error: 90, min_error: 80, allowed: [0, 0, 9, 8] };
        let parsed: Value = serde_json::from_str(&super::json(&quilting, &[record, record])).expect("JSON");
        let block = json!({
            "row": 1, "col": 2, "x": 52, "y": 26, "sx": 3, "sy": 4, "error": 90, "min_error": 80, "allowed": [0, 0, 9, 8]
        });
        let expected = json!({ "block": 32, "overlap": 6, "tolerance": 0.1, "seed": 7, "blocks": [block, block] });
        assert_eq!(parsed, expected);
        let empty: Value = serde_json::from_str(&super::json(&quilting, &[])).expect("JSON");
        assert_eq!(empty["blocks"], json!([]));
    }
}
