#include "core/layers/layers.hpp"

#include "tests/catch.hpp"
#include "tests/message_of.hpp"
#include "tests/random_shapes.hpp"

namespace {

constexpr Nanometers kFiftyMicrometers{50'000};

std::int32_t count_for(double height_mm, Nanometers thickness) {
  return layers_for(Millimeters{height_mm}, thickness).count;
}

}  // namespace

TEST_CASE("A model has as many layers as are cut below its top") {
  CHECK(count_for(10.0, kFiftyMicrometers) == 200);
  CHECK(count_for(10.03, kFiftyMicrometers) == 201);
  CHECK(count_for(0.03, kFiftyMicrometers) == 1);
}

TEST_CASE("A remainder that does not reach the middle of its layer is no layer") {
  CHECK(count_for(10.01, kFiftyMicrometers) == 200);
  CHECK(count_for(10.025, kFiftyMicrometers) == 200);  // a face at the height of the cut is below it
  CHECK(count_for(10.0 + 0.025, kFiftyMicrometers) == 200);
  CHECK(count_for(10.025001, kFiftyMicrometers) == 201);
  CHECK(count_for(0.02, kFiftyMicrometers) == 0);
  // 0.1 as a float is 1.5e-9 too large.
  CHECK(count_for(static_cast<double>(0.1F), Nanometers{100'000}) == 1);
}

TEST_CASE("A model without height has no layers") {
  CHECK(count_for(0.0, kFiftyMicrometers) == 0);
  CHECK(count_for(-1.0, kFiftyMicrometers) == 0);
}

TEST_CASE("Too many layers are refused with their number if it can be counted") {
  const auto complaint = [](double height_mm) -> std::string {
    return testing::message_of<TooManyLayers>(
        [&] { (void)layers_for(Millimeters{height_mm}, kFiftyMicrometers); });
  };
  const std::string uncounted = "the model has more than 10000000 layers";
  CHECK(count_for(500'000.01, kFiftyMicrometers) == 10'000'000);
  CHECK(complaint(500'000.03) == "the model has 10000001 layers, at most 10000000 can be printed");
  CHECK(complaint(1e8) == "the model has 2000000000 layers, at most 10000000 can be printed");
  CHECK(complaint(3e38) == uncounted);
  CHECK(complaint(1e300) == uncounted);
  CHECK(complaint(std::numeric_limits<double>::infinity()) == uncounted);
  CHECK(complaint(std::numeric_limits<double>::quiet_NaN()) == uncounted);
}

TEST_CASE("Each layer is cut at its middle") {
  const LayerStack layers{Nanometers{25'000}, 1000};
  CHECK(layers.middle_of(0) == Nanometers{12'500});
  CHECK(layers.middle_of(7) == Nanometers{187'500});
}

TEST_CASE("Layers of different thicknesses are stacked, each cut at its middle") {
  const std::vector<Nanometers> thicknesses{Nanometers{100'000}, Nanometers{30'000}, Nanometers{50'000}};
  CHECK(middles_of(thicknesses) == std::vector{Nanometers{50'000}, Nanometers{115'000}, Nanometers{155'000}});
  CHECK(middles_of({}).empty());
}

TEST_CASE("The highest layer that a print can have does not overflow") {
  const LayerStack layers{Nanometers{1'000'000}, std::numeric_limits<std::int32_t>::max()};
  CHECK(layers.middle_of(layers.count - 1) == Nanometers{2'147'483'646'500'000});
}

TEST_CASE("Every layer is cut below the model's top, and one more would not be") {
  CHECK(rc::check([] {
    const Nanometers thickness{testing::draw(1'000, 200'000)};
    const Nanometers height{testing::draw(1, 200'000'000)};
    const LayerStack layers = layers_for(to_millimeters(height), thickness);
    RC_ASSERT(layers.count >= 0);
    RC_ASSERT(layers.count == 0 || layers.middle_of(layers.count - 1) < height);
    RC_ASSERT(layers.middle_of(layers.count) >= height);
  }));
}
