// The benchmark's results: rows of one table, printed for people or as JSON. Values; not thread-safe.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace contourd::bench {

// Somebody else's figure for the same thing, in the row's unit.
struct Peer {
  std::string name;
  double figure = 0;
  bool cited = false;           // not run now: from a paper, or measured once before
  std::optional<double> cpu{};  // of all threads, in the row's unit
};

struct Target {
  enum class Kind { AtMost, AtLeast, TimesFirstPeer };  // TimesFirstPeer: first peer's figure over ours
  Kind kind = Kind::AtMost;
  double value = 0;
};

struct Row {
  std::string id;    // for --only and for programs that read the JSON
  std::string what;  // for people
  std::string unit;
  double figure = 0;            // wall time where it is a time
  std::optional<double> cpu{};  // CPU time of all threads, in the same unit
  std::optional<Target> target{};
  std::vector<Peer> peers{};
  std::string note{};
  std::string skipped{};  // why there is no figure, if there is none
};

// True and false as the target is reached; nothing without a target or figure.
[[nodiscard]] std::optional<bool> reached(const Row& row);

// The table, heading first, then rows as they come.
void print_heading();
void print_table_rows(const std::vector<Row>& rows);
// Throws std::runtime_error.
void write_json(const std::filesystem::path& path, const std::vector<Row>& rows, bool quick);

}  // namespace contourd::bench
