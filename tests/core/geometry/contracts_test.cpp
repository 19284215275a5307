// Checks that each header of core/geometry checks what it requires.
#include "core/geometry/point_hash.hpp"
#include "core/geometry/side_order.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"

TEST_CASE("SideOrder takes each side once, and only sides that it has room for") {
  if (testing::costly_checks_are_off()) return;
  SideOrder order;
  order.clear();
  order.reserve_numbers(2);
  CHECK(contract_broken_by([&] { order.insert_after(SideOrder::kNone, 2); }) ==
        "there is room for the side's number");
  order.insert_after(SideOrder::kNone, 0);
  CHECK(contract_broken_by([&] { order.insert_after(0, 1); }).empty());
  CHECK(contract_broken_by([&] { order.insert_after(0, 0); }) == "a side is not its own neighbour");
  CHECK(contract_broken_by([&] { order.insert_after(SideOrder::kNone, 0); }) ==
        "a side is not its own neighbour");
}

TEST_CASE("Hashing a point's bits requires coordinates that are not -0") {
  if (testing::costly_checks_are_off()) return;
  CHECK(contract_broken_by([] { (void)hash_of_bits({0.0, -1.0}); }).empty());
  CHECK(contract_broken_by([] { (void)hash_of_bits({-0.0, 1.0}); }) == "no coordinate is -0");
  CHECK(contract_broken_by([] { (void)hash_of_bits({1.0, -0.0}); }) == "no coordinate is -0");
  CHECK(contract_broken_by([] { (void)hash_of({-0.0, -0.0}); }).empty());
}
