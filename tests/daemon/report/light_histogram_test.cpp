#include "daemon/report/light_histogram.hpp"

#include "tests/catch.hpp"

namespace {

LayerRecord lit(std::int32_t number, Duration least, Duration most) {
  LayerRecord layer;
  layer.layer = number;
  layer.exposure_asked = 2s;
  layer.exposure_least = 2s + least;
  layer.exposure_most = 2s + most;
  layer.complete = true;
  return layer;
}

std::uint64_t count_of(const LightHistogram& histogram, std::uint64_t LightBin::*which) {
  return std::accumulate(histogram.bins.begin(), histogram.bins.end(), std::uint64_t{0},
                         [which](std::uint64_t sum, const LightBin& bin) { return sum + bin.*which; });
}

}  // namespace

TEST_CASE("Layers with exactly the requested exposure are in one bin around 0") {
  const std::vector<LayerRecord> layers{lit(0, 0ms, 0ms), lit(1, 0ms, 0ms)};
  const LightHistogram histogram = histogram_of_light(layers);
  REQUIRE(histogram.bins.size() == 1);
  CHECK(histogram.bins[0].middle_ms == 0);
  CHECK(histogram.bins[0].least == 2);
  CHECK(histogram.bins[0].most == 2);
  CHECK(histogram.exact);
  CHECK(histogram.layers == 2);
}

TEST_CASE("Every layer counts in the bin of its lower bound and in the bin of its upper bound") {
  const std::vector<LayerRecord> layers{lit(0, -3ms, 5ms), lit(1, 0ms, 5ms), lit(2, 0ms, 37ms)};
  const LightHistogram histogram = histogram_of_light(layers);
  CHECK(histogram.width_ms == 1);
  REQUIRE(histogram.bins.size() == 41);  // -3 to 37
  CHECK(histogram.bins.front().middle_ms == -3);
  CHECK(histogram.bins.front().least == 1);
  CHECK(histogram.bins[3].least == 2);
  CHECK(histogram.bins[8].most == 2);
  CHECK(histogram.bins.back().most == 1);
  CHECK_FALSE(histogram.exact);
  CHECK(histogram.farthest == 2);
  CHECK(histogram.farthest_ms == 37);
}

TEST_CASE("One outlier makes the bins wider, not more numerous") {
  std::vector<LayerRecord> layers;
  for (std::int32_t i = 0; i < 1000; ++i)
    layers.push_back(lit(i, 10us, 20us));
  for (const Duration far : {Duration(70ms), Duration(3s), Duration(10h), Duration(-2s)}) {
    layers.back() = lit(999, far, far);
    const LightHistogram histogram = histogram_of_light(layers);
    CHECK(histogram.bins.size() <= LightHistogram::kMaxBins);
    CHECK(count_of(histogram, &LightBin::least) == 1000);
    CHECK(count_of(histogram, &LightBin::most) == 1000);
    CHECK(histogram.farthest == 999);
    // The middle of one bin is 0.
    const double to_zero = histogram.bins.front().middle_ms / histogram.width_ms;
    CHECK(std::abs(to_zero - std::round(to_zero)) < 1e-9);
  }
}

TEST_CASE("Layers whose light was incomplete or not confirmed off are counted separately") {
  std::vector<LayerRecord> layers{lit(0, 0ms, 0ms), lit(1, -1s, -1s), lit(2, 0ms, 9h)};
  layers[1].complete = false;
  layers[2].dark_confirmed = false;
  const LightHistogram histogram = histogram_of_light(layers);
  CHECK(histogram.layers == 1);
  CHECK(histogram.left_out == 2);
  CHECK(histogram.bins.size() == 1);
  layers.erase(layers.begin());
  CHECK(histogram_of_light(layers).bins.empty());
  CHECK(histogram_of_light({}).bins.empty());
}

TEST_CASE("The drawing labels each bin with its layers and keeps one layer among thousands visible") {
  std::vector<LayerRecord> layers(20'000, lit(0, 0ms, 0ms));
  layers.push_back(lit(1, 4ms, 4ms));
  const std::string svg = svg_of(histogram_of_light(layers));
  CHECK(svg.find("<title>20000 layers: +0 ms</title>") != std::string::npos);
  CHECK(svg.find("height=\"3.0\"><title>1 layer: +4 ms</title>") != std::string::npos);
  CHECK(svg.find(">as requested</text>") != std::string::npos);
}
