#include "daemon/print/mask_cost.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <ctime>

#include "core/layers/layers.hpp"
#include "daemon/print/job_refused.hpp"

namespace contourd {
namespace {

using Milliseconds = std::chrono::duration<double, std::milli>;

Duration processor_time() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

// Returns the number of facets that each layer cuts, or of the points that its finished outlines have.
std::vector<std::int64_t> facets_cut(std::span<const PlateModel> models,
                                     std::span<const Nanometers> middles) {
  std::vector<std::int64_t> changes(middles.size() + 1, 0);
  for (const PlateModel& each : models) {
    if (each.outlines) {
      std::vector<std::int64_t> points;
      for (const Nanometers middle : middles)
        points.push_back(static_cast<std::int64_t>(each.outlines->points_at(middle)));
      return points;  // outlines are those of the whole plate
    }
    const auto first_above = [&](float z) {
      const auto lies_below = [&each](Nanometers middle, double height) {
        return each.z_at(middle).count() < height;
      };
      return std::lower_bound(middles.begin(), middles.end(), z, lies_below) - middles.begin();
    };
    for (const Facet& facet : each.model->facets()) {
      const auto [low, high] = std::minmax({facet.vertices[0].z, facet.vertices[1].z, facet.vertices[2].z});
      const auto copies = static_cast<std::int64_t>(each.copies.size());
      changes[static_cast<std::size_t>(first_above(low))] += copies;
      changes[static_cast<std::size_t>(first_above(high))] -= copies;
    }
  }
  changes.pop_back();
  for (std::size_t layer = 1; layer < changes.size(); ++layer)
    changes[layer] += changes[layer - 1];
  return changes;
}

struct SampledCost {
  MaskBudget spent;
  Duration time{};  // processor time
};

// Returns the cost of the mask at a height, measured as refuse_costly_masks() describes.
SampledCost sampled_cost(ContourEngine& engine, Nanometers height, Duration budget) {
  for (int budgets = kSampledBudgets;; budgets *= 4) {
    SampledCost cost{MaskBudget(MaskBudget::Clock::now() + budgets * budget)};
    const Duration before = processor_time();
    (void)engine.mask_within(height, cost.spent);
    cost.time = processor_time() - before;
    const bool was_held_up = cost.spent.overrun() && !cost.spent.too_many_sides() && cost.time <= budget;
    if (!was_held_up || budgets >= kMostSampledBudgets) return cost;
  }
}

}  // namespace

std::string describe_mask_cost(const ContourEngine& engine, const MaskBudget& spent, Duration time) {
  return fmt::format("{:.0f} ms, {} steps, {} facets cut{}", Milliseconds(time).count(), spent.steps(),
                     engine.intersecting_facets(),
                     spent.too_many_sides() ? ", more contour sides than the memory limit allows" : "");
}

std::vector<std::size_t> layers_to_sample(std::span<const PlateModel> models,
                                          std::span<const Nanometers> middles) {
  const std::vector<std::int64_t> facets = facets_cut(models, middles);
  std::vector<std::size_t> sample;
  for (std::size_t part = 0; part < kSampledLayers; ++part) {
    const auto begin = static_cast<std::ptrdiff_t>(facets.size() * part / kSampledLayers);
    const auto end = static_cast<std::ptrdiff_t>(facets.size() * (part + 1) / kSampledLayers);
    if (begin == end) continue;
    const auto most = std::max_element(facets.begin() + begin, facets.begin() + end);
    sample.push_back(static_cast<std::size_t>(most - facets.begin()));
  }
  return sample;
}

void refuse_costly_masks(ContourEngine& engine, std::span<const Nanometers> thicknesses, Duration budget) {
  const std::vector<Nanometers> middles = middles_of(thicknesses);
  for (const std::size_t layer : layers_to_sample(engine.models(), middles)) {
    const auto [spent, time] = sampled_cost(engine, middles[layer], budget);
    if (time > budget || spent.too_many_sides()) {
      throw JobRefused(fmt::format(
          "the mask of layer {} of {} takes longer than mask_budget_ms, {:.0f} ms: {}; the model is too fine "
          "or crosses itself too often",
          layer + 1, middles.size(), Milliseconds(budget).count(), describe_mask_cost(engine, spent, time)));
    }
  }
}

}  // namespace contourd
