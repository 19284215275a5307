// The benchmark's results: rows of one table, printed for people or as JSON. Values; not thread-safe.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace contourd::bench {

// Another program's figure for the same task, in the row's unit.
struct Peer {
  std::string name;
  double figure = 0;
  bool cited = false;           // not measured in this run, but taken from a paper or an earlier measurement
  std::optional<double> cpu{};  // CPU time of all threads, in the row's unit
};

struct Target {
  enum class Kind {
    AtMost,
    AtLeast,
    TimesFirstPeer
  };  // TimesFirstPeer: the first peer's figure divided by ours
  Kind kind = Kind::AtMost;
  double value = 0;
};

struct Row {
  std::string id;    // for --only and for programs that read the JSON
  std::string what;  // for people
  std::string unit;
  double figure = 0;            // wall time if the figure is a time
  std::optional<double> cpu{};  // CPU time of all threads, in the same unit
  std::optional<Target> target{};
  std::vector<Peer> peers{};
  std::string note{};
  std::string skipped{};  // the reason for a missing figure
};

// Returns true if the target is reached; nullopt if there is no target or no figure.
[[nodiscard]] std::optional<bool> reached(const Row& row);

// Prints the table's heading; print_table_rows() then prints rows as they come.
void print_heading();
void print_table_rows(const std::vector<Row>& rows);
// Writes the rows as JSON. Throws std::runtime_error if the file cannot be written.
void write_json(const std::filesystem::path& path, const std::vector<Row>& rows, bool quick);

}  // namespace contourd::bench
