// A state machine's table as a fixture: short names for the states, events and effects, questions about
// single transitions, and the checks that every table has to pass.
#pragma once

#include <algorithm>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hw/state_table.hpp"
#include "tests/catch.hpp"

namespace contourd::testing {

template <typename Row, const StateTable<Row>& (*table)()>
struct StateTableFixture {
  using S = typename Row::State;
  using E = typename Row::Event;
  using F = typename Row::Effect;

  // One event in one state.
  struct Transition {
    S from;
    E on;
    S to;
    std::vector<F> effects;
  };

  static const std::vector<Transition>& transitions() {
    static const std::vector<Transition> all = [] {
      std::vector<Transition> found;
      for_each_transition(table(), [&](S from, E on, const Row& row) {
        found.push_back({from, on, row.next(from), {row.done().begin(), row.done().end()}});
      });
      return found;
    }();
    return all;
  }
  // Returns the transition; null if the state ignores the event.
  static const Transition* find(S from, E on) {
    const auto found = std::ranges::find_if(
        transitions(), [&](const Transition& t) { return t.from == from && t.on == on; });
    return found != transitions().end() ? &*found : nullptr;
  }
  static std::set<S> all_states() {
    std::set<S> states;
    for (std::size_t state = 0; state < kNames<S>.size(); ++state)
      states.insert(static_cast<S>(state));
    return states;
  }
  static bool has(const Transition& transition, F effect) {
    return std::ranges::count(transition.effects, effect) > 0;
  }

  // Compares the table with its lines "event -> next state: effects (states)", written down independently of
  // it. States that agree share a line, which may continue in an indented one.
  static void check_lines(std::string expected) {
    for (std::size_t at = 0; (at = expected.find("\n    ", at)) != std::string::npos;)
      expected.replace(at, 5, " ");
    CHECK(lines() == expected);
  }

  // Checks that every state is reached and left, that no state has two rows for one event, and that all names
  // are known and differ; that every state answers the events that it has to; and that the light goes off
  // before anything that can fail.
  static void check_structure() {
    check_ways();
    check_rows();
    check_answers();
    check_light();
  }

 private:
  static std::string lines() {
    std::vector<std::pair<std::string, std::string>> all;
    for (const Transition& t : transitions()) {
      std::string what = std::string(name_of(t.on)) + " -> ";
      what += t.to == t.from ? "stay" : name_of(t.to);
      for (std::size_t i = 0; i < t.effects.size(); ++i)
        what += (i == 0 ? ": " : ", ") + std::string(name_of(t.effects[i]));
      const auto line = std::ranges::find(all, what, &std::pair<std::string, std::string>::first);
      if (line == all.end())
        all.emplace_back(what, name_of(t.from));
      else
        line->second += ", " + std::string(name_of(t.from));
    }
    std::string text = "\n";
    for (const auto& [what, states] : all)
      text += what + " (" + states + ")\n";
    return text;
  }
  // Returns the states to which transitions that pass `counts` lead from these states.
  template <typename Counts>
  static std::set<S> reached_from(std::set<S> states, const Counts& counts) {
    for (std::size_t before = 0; before != states.size();) {
      before = states.size();
      for (const Transition& t : transitions())
        if (states.contains(t.from) && counts(t)) states.insert(t.to);
    }
    return states;
  }
  static void check_ways() {
    const auto any = [](const Transition&) { return true; };
    CHECK(reached_from({table().start}, any) == all_states());
    for (const S state : all_states()) {
      CAPTURE(name_of(state));
      CHECK(reached_from({state}, any).contains(table().start));
    }
  }
  static void check_rows() {
    for (const Transition& t : transitions()) {
      CAPTURE(name_of(t.from), name_of(t.on));
      CHECK(std::ranges::count_if(table().rows, [&](const Row& row) {
              return row.from.contains(t.from) && row.on.contains(t.on);
            }) == 1);
      CHECK(std::ranges::count_if(t.effects, [](F effect) { return name_of(effect) == "?"; }) == 0);
    }
    CHECK(std::set(kNames<S>.begin(), kNames<S>.end()).size() == kNames<S>.size());
    CHECK(std::set(kNames<E>.begin(), kNames<E>.end()).size() == kNames<E>.size());
    CHECK(std::ranges::all_of(kNames<E>, [](std::string_view event) {
      return std::ranges::any_of(transitions(), [&](const Transition& t) { return name_of(t.on) == event; });
    }));
  }
  static void check_answers() {
    for (const auto& [event, except] : table().answered) {
      for (const S state : all_states()) {
        CAPTURE(name_of(state), name_of(event));
        CHECK((find(state, event) != nullptr) != except.contains(state));
      }
    }
  }
  static void check_light() {
    const auto is_on = [](F effect) { return table().light_on.contains(effect); };
    const auto is_off = [](F effect) { return table().light_off.contains(effect); };
    const auto is_harmless = [](F effect) { return table().harmless.contains(effect); };
    const auto turns_off = [&](const Transition& t) { return std::ranges::any_of(t.effects, is_off); };
    std::set<S> lit;
    for (const Transition& t : transitions())
      if (std::ranges::any_of(t.effects, is_on) && !turns_off(t)) lit.insert(t.to);
    lit = reached_from(lit, [&](const Transition& t) { return !turns_off(t); });
    CHECK_FALSE(lit.contains(table().start));
    for (const Transition& t : transitions()) {
      if (!turns_off(t) && !lit.contains(t.from)) continue;
      CAPTURE(name_of(t.from), name_of(t.on));
      CHECK(std::all_of(t.effects.begin(), std::ranges::find_if(t.effects, is_off), is_harmless));
    }
  }
};

}  // namespace contourd::testing
