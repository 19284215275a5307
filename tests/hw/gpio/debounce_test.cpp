#include "hw/gpio/debounce.hpp"

#include "tests/catch.hpp"

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
