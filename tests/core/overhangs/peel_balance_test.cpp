#include "core/overhangs/peel_balance.hpp"

#include "tests/catch.hpp"

using namespace contourd;

namespace {

// A layer with a single part of that many pixels, in one row.
struct Rows {
  explicit Rows(std::int32_t pixels) {
    Mask mask(Pixels{100}, Pixels{1});
    for (std::int32_t i = 0; i < pixels; ++i)
      mask.row(0)[static_cast<std::size_t>(i)] = 255;
    runs.extract(mask);
  }
  MaskRuns runs;
};

}  // namespace

TEST_CASE("A body is overloaded while half its layer is more than its contacts hold") {
  const Rows dark(0), wide(80);
  LayerParts parts;
  PeelBalance peel(15);
  parts.add_layer(wide.runs, dark.runs);
  peel.add_layer(parts);
  for (int contacts = 0; contacts < 3; ++contacts) {
    CHECK(peel.overloaded(0));
    peel.add_contact({contacts, 0}, 0);
  }
  CHECK_FALSE(peel.overloaded(0));
  peel.settle();
  CHECK(peel.load_pixels(0) == 40.0 / 3);
}

TEST_CASE("A body that stands on the plate is never overloaded") {
  const Rows dark(0), wide(80);
  LayerParts parts;
  PeelBalance peel(1);
  parts.add_layer(wide.runs, dark.runs);
  peel.add_layer(parts);
  peel.stand(0);
  CHECK_FALSE(peel.overloaded(0));
}

TEST_CASE("The place farthest from all contacts is taken, a steep one only if no other is left") {
  const Rows dark(0), wide(80);
  LayerParts parts;
  PeelBalance peel(1);
  parts.add_layer(wide.runs, dark.runs);
  peel.add_layer(parts);
  CHECK_FALSE(peel.take_place(0));
  peel.add_place({{10, 0}, 1, false}, 0);
  peel.add_place({{30, 0}, 1, false}, 0);
  peel.add_place({{79, 0}, 1, true}, 0);
  peel.add_contact({5, 0}, 0);
  for (const std::int32_t column : {30, 10, 79}) {
    const auto place = peel.take_place(0);
    REQUIRE(place);
    CHECK(place->at == SweepPixel{column, 0});
    peel.add_contact(place->at, 0);
  }
  CHECK_FALSE(peel.take_place(0));
}
