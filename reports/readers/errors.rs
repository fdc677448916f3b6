//! rustc -O errors.rs; ./errors transitions.csv mine.csv: the error of each value, paired with the truth.
//!
//! A line of the truth ends with value and bar, a line of yours with a value; what stands before them is the key. Equal
//! keys are paired in their order. Exit status 1 if a value has no partner.
use std::collections::{BTreeMap, BTreeSet};

fn read(path: &str, after_key: usize) -> BTreeMap<String, Vec<Vec<f64>>> {
    let mut rows = BTreeMap::new();
    let text = std::fs::read_to_string(path).expect("a readable file");
    for line in text.lines().skip(1).filter(|line| !line.trim().is_empty()) {
        let cells: Vec<&str> = line.trim().split(',').collect();
        let (key, values) = cells.split_at(cells.len() - after_key);
        let numbers = values.iter().map(|text| text.parse().expect("a number")).collect();
        rows.entry(key.join(",")).or_insert_with(Vec::new).push(numbers);
    }
    rows
}

fn main() {
    let files: Vec<String> = std::env::args().skip(1).collect();
    let (truth, mine) = (read(&files[0], 2), read(&files[1], 1));
    let case_of = |key: &str| key.split(',').next().unwrap_or("").to_string();
    let cases: BTreeSet<String> = mine.keys().map(|key| case_of(key)).collect();
    let (mut unpaired, none) = (0, Vec::new());
    println!("key,value,true,error,bar");
    for key in truth.keys().chain(mine.keys()).collect::<BTreeSet<_>>() {
        let (trues, values) = (truth.get(key).unwrap_or(&none), mine.get(key).unwrap_or(&none));
        if !cases.contains(&case_of(key)) { continue; } // a scene that you have not run
        for k in 0..trues.len().max(values.len()) {
            match (trues.get(k), values.get(k)) {
                (Some(right), None) => println!("{key},missed,{},,", right[0]),
                (None, Some(value)) => println!("{key},{},spurious,,", value[0]),
                (Some(t), Some(v)) => println!("{key},{},{},{:.3e},{:.1e}", v[0], t[0], v[0] - t[0], t[1]),
                (None, None) => unreachable!(),
            }
            unpaired += (k >= trues.len() || k >= values.len()) as i32;
        }
    }
    std::process::exit((unpaired > 0) as i32);
}
