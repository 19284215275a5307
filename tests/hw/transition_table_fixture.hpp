// A state machine's table as a fixture: short names for the states, events and effects, and questions about
// the rows.
#pragma once

#include <algorithm>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "hw/state_table.hpp"
#include "tests/catch.hpp"

namespace contourd::testing {

template <typename Transition, std::span<const Transition> (*transitions)()>
struct TransitionTableFixture {
  using S = typename Transition::State;
  using E = typename Transition::Event;
  using F = typename Transition::Effect;

  struct Row {
    S from;
    E on;
    S to;
    std::vector<F> effects;
  };

  static void check_rows(const std::vector<Row>& expected) {
    for (const Row& row : expected) {
      CAPTURE(name_of(row.from), name_of(row.on));
      const Transition* found = find(row.from, row.on);
      REQUIRE(found != nullptr);
      CHECK(found->to == row.to);
      CHECK(std::vector<F>(found->done().begin(), found->done().end()) == row.effects);
    }
    CHECK(transitions().size() == expected.size());
  }
  static void check_one_row_per_event() {
    std::set<std::pair<S, E>> seen;
    for (const Transition& t : transitions())
      CHECK(seen.insert({t.from, t.on}).second);
  }

  static std::set<S> all_states() {
    std::set<S> states;
    for (const Transition& t : transitions())
      states.insert({t.from, t.to});
    return states;
  }
  static const Transition* find(S from, E on) { return find_row(transitions(), from, on); }
  static bool has(const Transition& row, F effect) {
    return std::ranges::find(row.done(), effect) != row.done().end();
  }
};

}  // namespace contourd::testing
