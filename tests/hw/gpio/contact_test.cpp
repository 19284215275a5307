#include "hw/gpio/contact.hpp"

#include "tests/catch.hpp"

namespace {

constexpr Duration kContactDebounce = 5ms;

// Returns the states that the contact reaches by `now`.
std::vector<SafetyState> states(SafetyContact& contact, Duration now) {
  std::vector<SafetyState> all;
  while (const auto change = contact.change(TimePoint{now}))
    all.push_back(change->to);
  return all;
}
using States = std::vector<SafetyState>;
constexpr SafetyState kSafe = SafetyState::Safe, kDoubtful = SafetyState::Debouncing,
                      kUnsafe = SafetyState::Unsafe;

}  // namespace

TEST_CASE("A safety contact at rest has no change and nothing due") {
  SafetyContact contact(kContactDebounce, false);
  contact.read(false, TimePoint{1s});
  CHECK_FALSE(contact.due());
  CHECK(states(contact, 2s).empty());
}

TEST_CASE("A safety contact is unsafe from its first edge and has lasted after the debounce time") {
  SafetyContact contact(kContactDebounce, false);
  contact.edge(true, TimePoint{10ms});
  CHECK(states(contact, 10ms) == States{kDoubtful});
  CHECK(contact.due() == TimePoint{15ms});
  CHECK(states(contact, 15ms - 1ns).empty());
  const auto change = contact.change(TimePoint{15ms});
  REQUIRE(change);
  CHECK(change->from == kDoubtful);
  CHECK(change->to == kUnsafe);
  CHECK(change->since == TimePoint{10ms});
  CHECK_FALSE(contact.due());  // until it is released
}

TEST_CASE("A spike on a safety contact ends after a debounce time of quiet without having lasted") {
  SafetyContact contact(kContactDebounce, false);
  contact.edge(true, TimePoint{10ms});
  contact.edge(false, TimePoint{11ms});
  CHECK(states(contact, 12ms) == States{kDoubtful});
  CHECK(contact.due() == TimePoint{16ms});
  CHECK(states(contact, 16ms - 1ns).empty());
  CHECK(states(contact, 16ms) == States{kSafe});
  CHECK_FALSE(contact.due());
}

TEST_CASE("A spike and a press are told apart even if their edges are read late") {
  SafetyContact spike(kContactDebounce, false), press(kContactDebounce, false);
  spike.edge(true, TimePoint{10ms});
  spike.edge(false, TimePoint{11ms});
  CHECK(states(spike, 1s) == States{kDoubtful, kSafe});
  press.edge(true, TimePoint{10ms});
  press.edge(false, TimePoint{15ms});
  CHECK(states(press, 1s) == States{kDoubtful, kUnsafe, kSafe});
}

TEST_CASE("A safety contact that chatters for the debounce time has lasted, however short each pulse is") {
  SafetyContact contact(kContactDebounce, false);
  States all;
  for (int ms = 10; ms < 100; ms += 4) {  // at most 4 ms of quiet
    contact.edge(true, TimePoint{ms * 1ms});
    contact.edge(false, TimePoint{ms * 1ms + 100us});
    for (const SafetyState state : states(contact, ms * 1ms + 200us))
      all.push_back(state);
  }
  CHECK(all == States{kDoubtful, kUnsafe});
  CHECK(contact.due() == TimePoint{98ms + 100us + kContactDebounce});
  CHECK(states(contact, 98ms + 100us + kContactDebounce) == States{kSafe});
}

TEST_CASE("An edge to the safe level of a safe contact shows a missed edge, and counts") {
  SafetyContact contact(kContactDebounce, false);
  contact.edge(false, TimePoint{10ms});
  CHECK(states(contact, 10ms) == States{kDoubtful});
  CHECK(states(contact, 15ms) == States{kSafe});
}

TEST_CASE("A safety level that was read before its edge arrived settles from the edge on") {
  SafetyContact contact(kContactDebounce, false);
  contact.read(true, TimePoint{12ms});
  contact.edge(true, TimePoint{10ms});
  CHECK(states(contact, 12ms) == States{kDoubtful});
  CHECK(contact.due() == TimePoint{15ms});
}

TEST_CASE("A safety contact that is unsafe from the start counts as lasting") {
  SafetyContact contact(kContactDebounce, true);
  CHECK(contact.state() == kUnsafe);
  CHECK_FALSE(contact.due());
  contact.edge(false, TimePoint{10ms});
  CHECK(states(contact, 14ms).empty());
  CHECK(states(contact, 15ms) == States{kSafe});
}

TEST_CASE("A safety contact without a debounce time counts as lasting from its first edge on") {
  SafetyContact contact(Duration{0}, false);
  contact.edge(true, TimePoint{10ms});
  CHECK(states(contact, 10ms) == States{kDoubtful, kUnsafe});
  contact.edge(false, TimePoint{11ms});
  CHECK(states(contact, 11ms) == States{kSafe});
}

TEST_CASE("A bouncing contact settles once, with the time of its first edge") {
  Debounce contact(5ms, false);
  CHECK_FALSE(contact.due());
  for (const int ms : {10, 11, 12, 13, 14})
    contact.edge(ms % 2 == 0, TimePoint{ms * 1ms});
  CHECK(contact.due() == TimePoint{19ms});
  CHECK_FALSE(contact.settle(TimePoint{18ms}));
  CHECK_FALSE(contact.settled());
  const auto settled = contact.settle(TimePoint{19ms});
  REQUIRE(settled);
  CHECK(settled->level);
  CHECK(settled->changed);
  CHECK(settled->since == TimePoint{10ms});
  CHECK_FALSE(contact.settle(TimePoint{30ms}));
}

TEST_CASE("A level that was read before its edge arrived gets the edge's time") {
  Debounce contact(5ms, false);
  contact.read(true, TimePoint{12ms});
  contact.edge(true, TimePoint{10ms});
  const auto settled = contact.settle(TimePoint{17ms});
  REQUIRE(settled);
  CHECK(settled->since == TimePoint{10ms});
}

TEST_CASE("An edge that arrives late does not make a contact settle sooner") {
  Debounce contact(5ms, false);
  contact.read(true, TimePoint{12ms});
  contact.edge(true, TimePoint{10ms});
  CHECK(contact.due() == TimePoint{17ms});
  CHECK_FALSE(contact.settle(TimePoint{16ms}));
}

TEST_CASE("After a spike the contact settles to its old level") {
  Debounce contact(5ms, false);
  contact.edge(true, TimePoint{10ms});
  contact.edge(false, TimePoint{11ms});
  const auto settled = contact.settle(TimePoint{16ms});
  REQUIRE(settled);
  CHECK_FALSE(settled->changed);
  CHECK_FALSE(settled->level);
}

TEST_CASE("A level that differs from the last edge counts as an edge") {
  Debounce contact(5ms, false);
  contact.read(false, TimePoint{1ms});
  CHECK_FALSE(contact.due());
  contact.read(true, TimePoint{2ms});
  CHECK(contact.due() == TimePoint{7ms});
}
