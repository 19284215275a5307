// A state machine as one table: for each event in each state, the next state and the effects on the way. Pure
// values.
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "hw/enum_names.hpp"

namespace contourd {

// A set of enumerators of an enumeration that has at most 64, counted from 0. One enumerator or several
// convert to a set, so that a row of a table can name either.
template <typename Enum>
class EnumSet {
 public:
  constexpr EnumSet(Enum value) : bits_(bit(value)) {}
  constexpr EnumSet(std::initializer_list<Enum> values) {
    for (const Enum value : values)
      bits_ |= bit(value);
  }
  // Returns the set of all enumerators except these.
  static constexpr EnumSet all_except(std::initializer_list<Enum> values) {
    EnumSet rest(values);
    rest.bits_ = ~rest.bits_;
    return rest;
  }

  [[nodiscard]] constexpr bool contains(Enum value) const { return (bits_ & bit(value)) != 0; }

 private:
  static constexpr std::uint64_t bit(Enum value) { return std::uint64_t{1} << static_cast<int>(value); }

  std::uint64_t bits_ = 0;
};

// A row: in each of the states `from`, each of the events `on` leads to `to`, and causes the effects.
template <typename StateOf, typename EventOf, typename EffectOf>
struct StateTransition {
  using State = StateOf;
  using Event = EventOf;
  using Effect = EffectOf;
  static constexpr std::size_t kMaxEffects = 6;

  template <std::same_as<Effect>... Effects>
  constexpr StateTransition(EnumSet<State> from_, EnumSet<Event> on_, std::optional<State> to_,
                            Effects... all)
      : from(from_), on(on_), to(to_), effects{all...}, effect_count(sizeof...(all)) {
    static_assert(sizeof...(all) <= kMaxEffects);
  }

  EnumSet<State> from;
  EnumSet<Event> on;
  std::optional<State> to;                  // kStay: the state keeps waiting
  std::array<Effect, kMaxEffects> effects;  // in this order
  std::size_t effect_count;

  [[nodiscard]] State next(State state) const { return to.value_or(state); }
  [[nodiscard]] std::span<const Effect> done() const { return std::span(effects).first(effect_count); }
};

inline constexpr std::nullopt_t kStay = std::nullopt;

// A table and the rules that it keeps; tests/hw/state_table_fixture.hpp checks them.
template <typename Row>
struct StateTable {
  using Transition = Row;
  using State = typename Row::State;
  using Event = typename Row::Event;
  using Effect = typename Row::Effect;

  // An event that has a row in every state except these.
  struct Answered {
    Event event;
    EnumSet<State> except;
  };

  // Returns the row for an event in a state; null if the event is ignored there, because it comes too late.
  [[nodiscard]] const Row* find(State from, Event on) const {
    const auto found = std::ranges::find_if(
        rows, [&](const Row& row) { return row.from.contains(from) && row.on.contains(on); });
    return found != rows.end() ? &*found : nullptr;
  }

  std::span<const Row> rows;
  State start;  // every state is reached from here, and leads back here
  std::span<const Answered> answered;
  // Once one of the effects `light_on` has been performed, only the effects `harmless` may come before one of
  // the effects `light_off`.
  EnumSet<Effect> light_on{}, light_off{}, harmless{};
};

// Calls `call` with each state, event and row of the table, in the order of states and events.
template <typename Row, typename Call>
void for_each_transition(const StateTable<Row>& table, const Call& call) {
  for (std::size_t from = 0; from < kNames<typename Row::State>.size(); ++from) {
    for (std::size_t on = 0; on < kNames<typename Row::Event>.size(); ++on) {
      const auto state = static_cast<typename Row::State>(from);
      const auto event = static_cast<typename Row::Event>(on);
      if (const Row* const row = table.find(state, event)) call(state, event, *row);
    }
  }
}

// Returns the event's and the effects' names as a label in Graphviz.
template <typename Row>
[[nodiscard]] std::string label_of(typename Row::Event on, const Row& row) {
  std::string label(name_of(on));
  for (const auto effect : row.done())
    label += "\\n" + std::string(name_of(effect));
  return label;
}

// Draws the table as a part of a Graphviz graph. `name` keeps its states apart from those of other tables.
template <typename Row>
[[nodiscard]] std::string draw_table(const std::string& name, const StateTable<Row>& table) {
  const auto node = [&name](std::string_view state) {
    return "\"" + name + ": " + std::string(state) + "\"";
  };
  std::string part = "  subgraph \"cluster " + name + "\" {\n    label=\"" + name + "\";\n";
  for (const std::string_view state : kNames<typename Row::State>)
    part += "    " + node(state) + " [label=\"" + std::string(state) + "\"];\n";
  for_each_transition(table, [&](auto from, auto on, const Row& row) {
    part += "    " + node(name_of(from)) + " -> " + node(name_of(row.next(from))) + " [label=\"" +
            label_of(on, row) + "\"];\n";
  });
  return part + "  }\n";
}

}  // namespace contourd
