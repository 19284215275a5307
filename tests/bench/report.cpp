#include "tests/bench/report.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace contourd::bench {
namespace {

using Json = nlohmann::ordered_json;

std::string words_of(const Row& row) {
  if (!row.target) return "";
  switch (row.target->kind) {
    case Target::Kind::AtMost:
      return fmt::format("<= {:.4g}", row.target->value);
    case Target::Kind::AtLeast:
      return fmt::format(">= {:.4g}", row.target->value);
    case Target::Kind::TimesFirstPeer:
      return fmt::format(">= {:.4g} x", row.target->value);
  }
  return "";
}

std::string words_of(std::optional<bool> reached) {
  return !reached ? "" : *reached ? "yes" : "NO";
}

// Returns nullopt for a figure of zero, such as no allocations.
std::optional<double> ratio(const Row& row, const Peer& peer) {
  if (row.figure == 0) return std::nullopt;
  return peer.figure / row.figure;
}

void print_peer(const Row& row, const Peer& peer) {
  const std::optional<double> times = ratio(row, peer);
  fmt::print("{} {:.4g} {}{}", peer.name, peer.figure, row.unit, peer.cited ? " (cited)" : "");
  if (peer.cpu) fmt::print(" (CPU {:.4g})", *peer.cpu);
  if (times) fmt::print(", ratio {:.3g}", *times);
}

void print_row(const Row& row) {
  if (!row.skipped.empty()) return fmt::print("{:<66} SKIPPED: {}\n", row.what, row.skipped);
  const std::string cpu = row.cpu ? fmt::format("{:.4g}", *row.cpu) : "";
  fmt::print("{:<66} {:>9.4g} {:>9} {:<7} {:>10} {:>4}  ", row.what, row.figure, cpu, row.unit, words_of(row),
             words_of(reached(row)));
  for (std::size_t i = 0; i < row.peers.size(); ++i) {
    if (i > 0) fmt::print("\n{:<112}", "");
    print_peer(row, row.peers[i]);
  }
  fmt::print("\n");
  if (!row.note.empty()) fmt::print("    {}\n", row.note);
}

Json to_json(const Row& row) {
  Json json{{"id", row.id}, {"what", row.what}, {"unit", row.unit}};
  if (!row.skipped.empty()) {
    json["skipped"] = row.skipped;
    return json;
  }
  json["figure"] = row.figure;
  if (row.cpu) json["cpu"] = *row.cpu;
  if (row.target) json["target"] = words_of(row);
  if (const auto result = reached(row)) json["reached"] = *result;
  json["peers"] = Json::array();
  for (const Peer& peer : row.peers) {
    Json entry{{"name", peer.name}, {"figure", peer.figure}, {"cited", peer.cited}};
    if (peer.cpu) entry["cpu"] = *peer.cpu;
    if (const auto times = ratio(row, peer)) entry["ratio"] = *times;
    json["peers"].push_back(entry);
  }
  if (!row.note.empty()) json["note"] = row.note;
  return json;
}

}  // namespace

std::optional<bool> reached(const Row& row) {
  if (!row.target || !row.skipped.empty()) return std::nullopt;
  switch (row.target->kind) {
    case Target::Kind::AtMost:
      return row.figure <= row.target->value;
    case Target::Kind::AtLeast:
      return row.figure >= row.target->value;
    case Target::Kind::TimesFirstPeer:
      if (row.peers.empty() || row.peers.front().cited) return std::nullopt;
      return row.peers.front().figure >= row.target->value * row.figure;
  }
  return std::nullopt;
}

void print_heading() {
  fmt::print("{:<66} {:>9} {:>9} {:<7} {:>10} {:>4}  {}\n", "what", "ours", "CPU", "unit", "target", "",
             "peers");
  std::fflush(stdout);
}

void print_table_rows(const std::vector<Row>& rows) {
  for (const Row& row : rows)
    print_row(row);
  std::fflush(stdout);
}

void write_json(const std::filesystem::path& path, const std::vector<Row>& rows, bool quick) {
  Json json{{"quick", quick}, {"rows", Json::array()}};
  for (const Row& row : rows)
    json["rows"].push_back(to_json(row));
  std::ofstream file(path);
  file << json.dump(1) << '\n';
  file.close();
  if (!file) throw std::runtime_error("cannot write " + path.string());
}

}  // namespace contourd::bench
