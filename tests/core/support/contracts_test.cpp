// Checks that each header of core/support enforces its requirements.

#include "core/support/support_lift.hpp"
#include "core/support/support_structure.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/models/models.hpp"

TEST_CASE("SupportStructure takes primitives that have a place and a size") {
  const auto broken_by = [](const SupportPrimitive& primitive) {
    return contract_broken_by([&] { SupportStructure{{primitive}}; });
  };
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const std::string sentence = "every primitive has a place and a size";
  for (const SupportPrimitive& primitive :
       {SupportPrimitive{Ball{{kNone, 0, 0}, 1}}, SupportPrimitive{Ball{{0, 0, 2e6}, 1}},
        SupportPrimitive{Ball{{0, 0, 0}, -1}}, SupportPrimitive{Frustum{{0, 0, 0}, {0, 0, kNone}, 1, 1}},
        SupportPrimitive{Frustum{{0, 0, 0}, {0, 0, 1}, 0, 0}},
        SupportPrimitive{Frustum{{0, 0, 1}, {0, 0, 0}, 1, 1}},
        SupportPrimitive{Frustum{{0, 0, 1}, {0, 0, 1}, 1, 1}},
        SupportPrimitive{Frustum{{0, 0, 0}, {0, 0, 1}, 2e6, 1}},
        SupportPrimitive{Frustum{{0, 0, 0}, {0, 0, 1}, 1, -1}}})
    CHECK(broken_by(primitive) == sentence);
  CHECK(broken_by(Frustum{{0, 0, 0}, {1, 0, 0}, 0, 1}) != sentence);
}

TEST_CASE("A lift needs a layer with a thickness") {
  const HeightIndex model(models::box({0, 0, 0}, {1, 1, 1}));
  CHECK(contract_broken_by([&] { (void)support_lift(model, {}, Nanometers{1}); }).empty());
  CHECK(contract_broken_by([&] { (void)support_lift(model, {}, Nanometers{}); }) ==
        "a layer has a thickness");
}
