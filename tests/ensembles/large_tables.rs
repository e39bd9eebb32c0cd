//! Tables of many kept paths are written row by row, not made whole in memory.

use allocation_counter::measure;
use fixtures::small::Rotation;
use wzvi::ensemble::Statistics;
use wzvi::prelude::*;

const PATHS: u64 = 130_000;

fn statistics() -> Statistics {
    let rotation = Rotation { omega: 1.0 };
    let run = rotation.ensemble::<Midpoint>(0.1).starts(|draw| State::new([draw.normal()], [draw.normal()]));
    let run = run.paths(PATHS).steps(1).threads(1).observe("q", |state| state.q[0]);
    run.first_passage("zero", |state| state.q[0]).keep_paths(1 << 30).run().expect("an ensemble")
}

#[test]
fn files_of_kept_paths_take_the_memory_of_a_part() {
    let statistics = statistics();
    let folder = fixtures::folder!("tables");
    let csv = measure(|| statistics.write_csv(&folder).expect("files"));
    println!("csv {} bytes", csv.bytes_max);
    // 260 000 rows of three numbers are 6.2 MB, and 130 000 names twice are 8.7 MB and more; a part of 32 768 rows has below 4 MB, doubled as its
    // vectors grow, and its encoded pages.
    assert!(csv.bytes_max < 8 << 20, "{}", csv.bytes_max);
    let file = folder.join("all.json");
    let json = measure(|| statistics.write_json(&file).expect("a file"));
    println!("json {} bytes", json.bytes_max);
    assert!(json.bytes_max < 8 << 20, "{}", json.bytes_max);
    let all = std::fs::read_to_string(file).expect("a file");
    let entries = |table: &str, column: &str| {
        let (_, table) = all.split_once(&format!("\"{table}\":{{")).expect("the table");
        let (_, column) = table.split_once(&format!("\"{column}\":[")).expect("the column");
        column.split_once(']').expect("a list").0.matches(',').count() + 1
    };
    let parquet = measure(|| statistics.write_parquet(&folder).expect("files"));
    println!("parquet {} bytes", parquet.bytes_max);
    assert!(parquet.bytes_max < 12 << 20, "{}", parquet.bytes_max);
    // The same rows as the tables in memory.
    let mut tables = Vec::new();
    let whole = measure(|| tables = statistics.tables());
    println!("tables in memory {} bytes", whole.bytes_max);
    for name in ["paths", "path_passages"] {
        let table = fixtures::table(&tables, name);
        for (column, _) in table.columns() {
            assert_eq!(entries(name, column), table.rows(), "{column}");
        }
        let mut text = Vec::new();
        table.write_csv(&mut text).expect("bytes");
        assert!(
            table.rows() as u64 >= PATHS
                && std::fs::read(folder.join(name).with_extension("csv")).expect("a file") == text
        );
    }
    std::fs::remove_dir_all(folder).expect("removed");
}
