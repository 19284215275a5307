#include "daemon/print/mask_cost.hpp"

#include <sched.h>
#include <sys/resource.h>

#include <thread>

#include "daemon/print/job_refused.hpp"
#include "tests/catch.hpp"
#include "tests/message_of.hpp"
#include "tests/models/damage.hpp"
#include "tests/models/models.hpp"

namespace {

const DisplayGeometry kFullHdDisplay{Pixels{1920}, Pixels{1080}, Micrometers{50.0}};

ContourEngine engine_of(const models::Facets& facets, Elevation elevation = {}) {
  const StandingModel model{std::make_shared<const HeightIndex>(facets), elevation};
  return {{PlateModel{model, {PixelMap::true_scale(kFullHdDisplay, {0, 0})}}}, {.display = kFullHdDisplay}};
}

// Returns this number of random facets, nearly all of which cross each other at a middle height.
models::Facets soup(std::size_t count) {
  models::Dice dice(11);
  models::Facets facets(count);
  for (Facet& facet : facets) {
    for (Vertex& v : facet.vertices)
      v = dice.in_ball(20);
  }
  return facets;
}

std::string refusal_of(ContourEngine& engine, std::span<const Nanometers> layers, Duration budget) {
  return testing::message_of<JobRefused>([&] { refuse_costly_masks(engine, layers, budget); });
}

}  // namespace

TEST_CASE("A print whose masks cross themselves too often is refused with the figures") {
  ContourEngine engine = engine_of(soup(4000));
  // Some hundred thousand crossings take longer than a millisecond on any machine.
  const std::string refusal = refusal_of(engine, std::vector(400, Nanometers{100'000}), 1ms);
  CAPTURE(refusal);
  CHECK(refusal.find("mask_budget_ms, 1 ms") != std::string::npos);
  CHECK(refusal.find("facets cut") != std::string::npos);
}

TEST_CASE("A print whose masks take too long is refused even if other threads occupy the processor") {
  ContourEngine engine = engine_of(soup(4000));
  std::string refusal;
  // On one processor, next to a thread of lower niceness, this thread gets a tenth of the time: less than
  // half a budget within four budgets.
  std::jthread check([&] {
    cpu_set_t allowed{};
    REQUIRE(sched_getaffinity(0, sizeof allowed, &allowed) == 0);
    int processor = 0;
    while (!CPU_ISSET(static_cast<std::size_t>(processor), &allowed))
      ++processor;
    cpu_set_t one{};
    CPU_SET(static_cast<std::size_t>(processor), &one);
    REQUIRE(sched_setaffinity(0, sizeof one, &one) == 0);
    const std::jthread other([](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
      }
    });
    REQUIRE(setpriority(PRIO_PROCESS, 0, 10) == 0);
    refusal = refusal_of(engine, std::vector(400, Nanometers{100'000}), 20ms);
  });
  check.join();
  CAPTURE(refusal);
  CHECK(refusal.find("mask_budget_ms, 20 ms") != std::string::npos);
}

TEST_CASE("A sample contains, for each part of the print, the layer that cuts the most facets") {
  // A thin slice of many facets, 1 um at 6.5 mm, beside a column of 10 mm.
  models::Facets facets = models::box({-5, -5, 0}, {5, 5, 10});
  models::Facets slice = models::box({-5, -5, 6.4999F}, {5, 5, 6.5009F});
  facets.insert(facets.end(), slice.begin(), slice.end());
  const ContourEngine engine = engine_of(facets);
  std::vector<Nanometers> middles;
  for (int layer = 0; layer < 10'000; ++layer)
    middles.push_back(Nanometers{1000 * layer + 500});
  const std::vector<std::size_t> sample = layers_to_sample(engine.models(), middles);
  CHECK(sample ==
        std::vector<std::size_t>{0, 833, 1666, 2500, 3333, 4166, 5000, 6500, 6666, 7500, 8333, 9166});
  // With the model 2 mm above the plate, the slice is in the layers 2 mm higher.
  CHECK(layers_to_sample(engine_of(facets, Elevation(Nanometers{2'000'000})).models(), middles) ==
        std::vector<std::size_t>{0, 833, 2000, 2500, 3333, 4166, 5000, 5833, 6666, 7500, 8500, 9166});
  CHECK(layers_to_sample(engine.models(), {}).empty());
  CHECK(layers_to_sample(engine.models(), std::span(middles).first(1)) == std::vector<std::size_t>{0});
}

TEST_CASE("A print whose masks keep their budget is not refused") {
  ContourEngine engine = engine_of(models::box({-5, -5, 0}, {5, 5, 10}));
  CHECK(refusal_of(engine, std::vector(100, Nanometers{100'000}), 1h).empty());
  CHECK(refusal_of(engine, std::vector(1, Nanometers{100'000}), 1h).empty());
}
