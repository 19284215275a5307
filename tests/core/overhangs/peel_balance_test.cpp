#include "core/overhangs/peel_balance.hpp"

#include "tests/catch.hpp"
#include "tests/core/text_mask.hpp"

namespace {

constexpr double kWidth = 2;    // of a tip, in pixels
constexpr double kSpacing = 0;  // of contacts

// A body whose layer is a row of 80 pixels.
struct WideBody {
  explicit WideBody(double contact_holds) : peel({contact_holds, kWidth}, kSpacing) {
    parts.add_layer(lit, testing::runs_of({std::string(100, '.')}));
    peel.add_layer(parts);
  }
  [[nodiscard]] bool overloaded() const { return peel.overloaded(peel.pulls()[0]); }
  [[nodiscard]] std::optional<PeelBalance::Place> place() { return peel.place_against(peel.pulls()[0]); }

  MaskRuns lit = testing::runs_of({std::string(80, '#') + std::string(20, '.')});
  LayerParts parts;
  PeelBalance peel;
};

}  // namespace

TEST_CASE("A body is overloaded while half its layer is more than its contacts hold") {
  WideBody body(15);
  for (const std::int32_t column : {19, 60, 39}) {
    CHECK(body.overloaded());
    body.peel.add_contact({column, 0}, 0);
  }
  CHECK_FALSE(body.overloaded());
  body.peel.settle();
  // The contacts' centre is 0.17 pixels beside the pull's.
  CHECK(body.peel.load_pixels(0) == testing::Approx(40.0 / 3).epsilon(0.02));
}

TEST_CASE("A body is overloaded if its layer pulls far beside its contacts, however many hold it") {
  WideBody body(15);
  for (int contacts = 0; contacts < 6; ++contacts)
    body.peel.add_contact({contacts, 0}, 0);
  CHECK(body.overloaded());
  body.peel.settle();
  // The contacts are 1.7 pixels from their centre in the mean, and the pull is 37 pixels from it.
  CHECK(body.peel.load_pixels(5) > 15);
  body.peel.add_place({{45, 0}, 1, false}, 0);
  body.peel.add_place({{10, 0}, 1, false}, 0);
  body.peel.add_place({{70, 0}, 1, true}, 0);
  const auto place = body.place();
  REQUIRE(place);
  CHECK(place->at == SweepPixel{70, 0});
  body.peel.add_contact(place->at, 0);
  body.peel.add_contact({79, 0}, 0);
  CHECK_FALSE(body.overloaded());
}

TEST_CASE("A body that stands on the plate is overloaded only by a lever") {
  WideBody body(1);
  body.peel.stand(body.parts, body.lit);
  CHECK_FALSE(body.overloaded());
  WideBody leaning(1);
  leaning.peel.stand(leaning.parts, testing::runs_of({"##" + std::string(98, '.')}));
  CHECK(leaning.overloaded());
}

TEST_CASE("Each part of a body has to be borne alone") {
  const MaskRuns row = testing::runs_of({std::string(101, '#')});
  const MaskRuns ends =
      testing::runs_of({std::string(30, '#') + std::string(41, '.') + std::string(30, '#')});
  LayerParts parts;
  PeelBalance peel({100, kWidth}, kSpacing);
  parts.add_layer(row, testing::runs_of({std::string(101, '.')}));
  peel.add_layer(parts);
  peel.add_contact({50, 0}, 0);
  parts.add_layer(ends, row);
  peel.add_layer(parts);
  REQUIRE(peel.pulls().size() == 3);
  CHECK_FALSE(peel.overloaded(peel.pulls()[0]));
  CHECK(peel.overloaded(peel.pulls()[1]));
  CHECK(peel.overloaded(peel.pulls()[2]));
}

TEST_CASE("The place farthest from all contacts is taken, a steep one only if no other is left") {
  WideBody body(1);
  CHECK_FALSE(body.place());
  body.peel.add_place({{10, 0}, 1, false}, 0);
  body.peel.add_place({{30, 0}, 1, false}, 0);
  body.peel.add_place({{79, 0}, 1, true}, 0);
  body.peel.add_contact({5, 0}, 0);
  for (const std::int32_t column : {30, 10, 79}) {
    const auto place = body.place();
    REQUIRE(place);
    CHECK(place->at == SweepPixel{column, 0});
    body.peel.add_contact(place->at, 0);
  }
  CHECK_FALSE(body.place());
}
