// A state machine as one table: for each event in each state, the next state and the effects on the way. Pure
// values.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <set>
#include <span>
#include <string>

namespace contourd {

template <typename StateOf, typename EventOf, typename EffectOf>
struct StateTransition {
  using State = StateOf;
  using Event = EventOf;
  using Effect = EffectOf;
  static constexpr std::size_t kMaxEffects = 6;

  State from;
  Event on;
  State to;
  std::array<Effect, kMaxEffects> effects;  // in this order
  std::size_t effect_count;

  [[nodiscard]] std::span<const Effect> done() const { return std::span(effects).first(effect_count); }
};

// Returns the row for an event in a state; null if the event is ignored there.
template <typename Row>
[[nodiscard]] const Row* find_row(std::span<const Row> table, typename Row::State from,
                                  typename Row::Event on) {
  const auto found =
      std::ranges::find_if(table, [&](const Row& row) { return row.from == from && row.on == on; });
  return found != table.end() ? &*found : nullptr;
}

// Draws the table as a part of a Graphviz graph. `name` keeps its states apart from those of other tables.
template <typename Row>
[[nodiscard]] std::string draw_table(const std::string& name, std::span<const Row> table) {
  std::set<typename Row::State> states;
  for (const Row& row : table)
    states.insert({row.from, row.to});
  const auto node = [&name](typename Row::State state) {
    return "\"" + name + ": " + std::string(name_of(state)) + "\"";
  };
  std::string part = "  subgraph \"cluster " + name + "\" {\n    label=\"" + name + "\";\n";
  for (const auto state : states)
    part += "    " + node(state) + " [label=\"" + std::string(name_of(state)) + "\"];\n";
  for (const Row& row : table) {
    std::string label(name_of(row.on));
    for (const auto effect : row.done())
      label += "\\n" + std::string(name_of(effect));
    part += "    " + node(row.from) + " -> " + node(row.to) + " [label=\"" + label + "\"];\n";
  }
  return part + "  }\n";
}

}  // namespace contourd
