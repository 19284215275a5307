#include "tests/bench/report.hpp"

#include "tests/catch.hpp"

using namespace contourd::bench;

TEST_CASE("A row's target is reached at its own value") {
  CHECK(reached({"", "", "s", 0.1, {}, Target{Target::Kind::AtMost, 0.1}}) == true);
  CHECK(reached({"", "", "s", 0.11, {}, Target{Target::Kind::AtMost, 0.1}}) == false);
  CHECK(reached({"", "", "MB/s", 250, {}, Target{Target::Kind::AtLeast, 250}}) == true);
  CHECK(reached({"", "", "MB/s", 249, {}, Target{Target::Kind::AtLeast, 250}}) == false);
}

TEST_CASE("A target relative to a peer is judged only if the peer was run") {
  Row row{"", "", "s", 2, {}, Target{Target::Kind::TimesFirstPeer, 8}};
  CHECK_FALSE(reached(row).has_value());
  row.peers = {{"peer", 16, true}};
  CHECK_FALSE(reached(row).has_value());
  row.peers = {{"peer", 16, false}};
  CHECK(reached(row) == true);
  row.peers = {{"peer", 15, false}};
  CHECK(reached(row) == false);
}

TEST_CASE("A row that was skipped or has no target has no result") {
  Row row{"", "", "s", 0, {}, Target{Target::Kind::AtMost, 1}};
  row.skipped = "no model";
  CHECK_FALSE(reached(row).has_value());
  CHECK_FALSE(reached({"", "", "s", 1}).has_value());
}
