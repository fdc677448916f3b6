#!/usr/bin/env node
// node errors.js transitions.csv mine.csv: the error of each value, paired with the truth.
//
// A line of the truth ends with value and bar, a line of yours with a value; what stands before them is the key. Equal
// keys are paired in their order. Exit status 1 if a value has no partner.
const fs = require("fs");

function read(path, afterKey) {
  const rows = new Map();
  for (const line of fs.readFileSync(path, "utf8").split(/\r?\n/).slice(1).filter((text) => text.trim())) {
    const cells = line.trim().split(","), key = cells.slice(0, -afterKey).join(",");
    if (!rows.has(key)) rows.set(key, []);
    rows.get(key).push(cells.slice(-afterKey).map(Number));
  }
  return rows;
}

const truth = read(process.argv[2], 2), mine = read(process.argv[3], 1);
const ofCase = (key) => key.split(",")[0], cases = new Set([...mine.keys()].map(ofCase));
let unpaired = 0;
console.log("key,value,true,error,bar");
for (const key of [...new Set([...truth.keys(), ...mine.keys()])].sort()) {
  if (!cases.has(ofCase(key))) continue; // a scene that you have not run
  const trues = truth.get(key) ?? [], values = mine.get(key) ?? [];
  for (let k = 0; k < Math.max(trues.length, values.length); k++) {
    if (k >= values.length) console.log(`${key},missed,${trues[k][0]},,`);
    else if (k >= trues.length) console.log(`${key},${values[k][0]},spurious,,`);
    else {
      const [[value], [right, bar]] = [values[k], trues[k]];
      console.log(`${key},${value},${right},${(value - right).toExponential(3)},${bar.toExponential(1)}`);
      continue;
    }
    unpaired++;
  }
}
process.exitCode = unpaired ? 1 : 0;
