// c++ -O2 -std=c++17 -o errors errors.cpp; ./errors transitions.csv mine.csv: the error of each value, paired with the
// truth. A line of the truth ends with value and bar, a line of yours with a value; what stands before them is the key.
// Equal keys are paired in their order. Exit status 1 if a value has no partner.
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>
using Rows = std::map<std::string, std::vector<std::pair<double, double>>>;  // values and bars by key

Rows read(const char* path, bool with_bar) {
  Rows rows;
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);  // the names of the columns
  while (std::getline(file, line)) {
    if (line.find(',') == std::string::npos) continue;
    auto end = line.rfind(','), start = with_bar ? line.rfind(',', end - 1) : end;
    double bar = with_bar ? std::stod(line.substr(end + 1)) : 0.0;
    rows[line.substr(0, start)].push_back({std::stod(line.substr(start + 1)), bar});
  }
  return rows;
}

int main(int, char** argv) {
  Rows truth = read(argv[1], true), mine = read(argv[2], false), every = truth;
  std::set<std::string> cases;
  for (auto& row : mine) cases.insert(row.first.substr(0, row.first.find(','))), every.insert(row);
  int unpaired = 0;
  std::puts("key,value,true,error,bar");
  for (auto& [key, rest] : every) {
    if (!cases.count(key.substr(0, key.find(',')))) continue;  // a scene that you have not run
    auto &trues = truth[key], &values = mine[key];
    for (size_t k = 0; k < std::max(trues.size(), values.size()); k++) {
      if (k >= values.size()) unpaired++, std::printf("%s,missed,%.17g,,\n", key.c_str(), trues[k].first);
      else if (k >= trues.size()) unpaired++, std::printf("%s,%.17g,spurious,,\n", key.c_str(), values[k].first);
      else std::printf("%s,%.17g,%.17g,%.3e,%.1e\n", key.c_str(), values[k].first, trues[k].first,
                       values[k].first - trues[k].first, trues[k].second);
    }
  }
  return unpaired > 0;
}
