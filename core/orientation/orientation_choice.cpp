#include "core/orientation/orientation_choice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "core/contract/expects.hpp"
#include "core/model/height_index.hpp"
#include "core/orientation/candidate_directions.hpp"
#include "core/orientation/exposed_parts.hpp"
#include "core/orientation/nearly_level_base.hpp"
#include "core/orientation/orientation_rating.hpp"
#include "core/orientation/orientation_trial.hpp"
#include "core/orientation/rated_mesh.hpp"
#include "core/overhangs/carried_supports.hpp"
#include "core/overhangs/overhang_sweep.hpp"

namespace contourd {
namespace {

// A model is turned only if another direction is better by this part of the sum of all weights.
constexpr double kWorthTurning = 0.05;
// The rating rarely estimates more than this many times the contacts that a trial finds.
constexpr double kMostOverestimated = 1.6;

// The worst figures of all directions tried, which make figures comparable. The initial values are minimums:
// without them a single contact would decide.
struct Worst {
  double contacts = 4, support_mm3 = 20, largest_mm2 = 1, height_mm = 1, touched_mm2 = 1;

  void take(const OrientationFigures& figures) {
    contacts = std::max(contacts, figures.contacts);
    support_mm3 = std::max(support_mm3, figures.support_mm3);
    largest_mm2 = std::max(largest_mm2, figures.largest_mm2);
    height_mm = std::max(height_mm, figures.size_z_mm);
    touched_mm2 = std::max(touched_mm2, figures.touched_mm2);
  }
};

// Returns the score: the weighted sum of the figures. The square root is taken of the support figures,
// because the step from none to a few matters more than the step from many to some more.
double score_of(const OrientationFigures& figures, const OrientationWeights& weights, const Worst& worst) {
  return weights.support * std::sqrt(figures.support_mm3 / worst.support_mm3) +
         weights.contacts * std::sqrt(figures.contacts / worst.contacts) +
         weights.peel * figures.largest_mm2 / worst.largest_mm2 +
         weights.height * figures.size_z_mm / worst.height_mm + (figures.stands ? 0 : weights.standing) +
         weights.keep_clean * figures.touched_mm2 / worst.touched_mm2;
}

// Sorts the directions: those that fit first, best first; equal ones keep their order. Areas may overflow: a
// score that is not finite is replaced by the largest number.
void rank(std::vector<OrientationFigures>& rated, const OrientationWeights& weights, const Worst& worst) {
  for (OrientationFigures& figures : rated)
    if (figures.score = score_of(figures, weights, worst); !std::isfinite(figures.score))
      figures.score = std::numeric_limits<double>::max();
  std::ranges::stable_sort(rated, [](const OrientationFigures& a, const OrientationFigures& b) {
    return a.fits != b.fits ? a.fits : a.score < b.score;
  });
}

using Ranked = std::vector<OrientationFigures>;

// True if the model, as drawn, lies on the plate with a face that is exactly level.
bool lies_level(std::span<const Facet> facets) {
  // A micrometre, and the sine of 0.005 degrees: more than rounding, less than any layer.
  constexpr double kHigherMm = 1e-3, kLevelSine = 8.7e-5, kLeastMm2 = 1;
  const double lowest = bounds_of(facets).min_z;
  double level_mm2 = 0;
  for (const Facet& facet : facets) {
    if (heights_of(facet).high > lowest + kHigherMm) continue;
    const Direction area = area_of(facet);
    if (std::hypot(area.x, area.y) < -kLevelSine * area.z) level_mm2 -= area.z;
  }
  return level_mm2 >= kLeastMm2;
}

// Returns the model as drawn, or with its base flat on the plate if it is drawn nearly so. The flat base may
// be worse by `slack`, for its wide first layer, if it needs no more contacts.
Ranked::iterator as_meant(Ranked& ranked, double slack) {
  const auto drawn = std::ranges::find(ranked, kAsDrawn, &OrientationFigures::up);
  const auto level = std::ranges::find_if(ranked, [&](const OrientationFigures& each) {
    const bool as_good = each.score <= drawn->score ||
                         (each.score <= drawn->score + slack && each.contacts <= drawn->contacts &&
                          each.touched_mm2 <= drawn->touched_mm2);
    return each.stands && each.up.z > kCosNearlyLevel && each.up != kAsDrawn && each.fits == drawn->fits &&
           as_good;
  });
  return level != ranked.end() ? level : drawn;
}

// Moves the direction to be printed to the front. `level`: the model lies level as drawn.
void choose(OrientationChoice& choice, const OrientationWeights& weights, bool level) {
  Ranked& ranked = choice.ranked;
  const double all = weights.support + weights.contacts + weights.peel + weights.height + weights.standing;
  const auto meant = level ? std::ranges::find(ranked, kAsDrawn, &OrientationFigures::up)
                           : as_meant(ranked, kWorthTurning * all);
  const bool may_stay = meant->fits || !ranked.front().fits;
  const bool good_enough = meant->score <= ranked.front().score + kWorthTurning * all;
  if (may_stay && (good_enough || choice.own_supports)) std::rotate(ranked.begin(), meant, meant + 1);
}

class Choosing {
 public:
  Choosing(const HeightIndex& model, const OrientationRequest& request, const std::stop_token& stop)
      : facets_(model.facets()), request_(request), stop_(stop), exposed_(exposed_parts(facets_)) {}

  std::optional<OrientationChoice> choose() {
    const std::vector<Direction> candidates = candidate_directions(facets_);
    Ranked sampled = rate_by_sample(candidates);
    if (stop_.stop_requested()) return std::nullopt;
    take_worst(sampled);
    rank(sampled, request_.weights, worst_);
    Ranked rated = rate_finalists(sampled);
    if (stop_.stop_requested()) return std::nullopt;
    take_worst(rated);
    rank(rated, request_.weights, worst_);
    OrientationChoice choice = try_best(rated);
    if (stop_.stop_requested()) return std::nullopt;
    choice.tried = static_cast<std::uint32_t>(candidates.size());
    choice.steps = steps_;
    take_worst(choice.ranked);
    rank(choice.ranked, request_.weights, worst_);
    contourd::choose(choice, request_.weights, lies_level(facets_));
    return choice;
  }

 private:
  [[nodiscard]] RatedMesh::Making making(std::span<const Facet> facets) const {
    const Scale& scale = request_.scale;
    // Converted to the model's own millimetres.
    const double cell_mm = kContactCellMm / std::max({scale.x, scale.y, scale.z});
    return {.facets = facets, .cell_mm = cell_mm, .keep_clean = request_.keep_clean};
  }

  void take_worst(const Ranked& rated) {
    for (const OrientationFigures& figures : rated)
      worst_.take(figures);
  }

  Ranked rate_by_sample(std::span<const Direction> candidates) {
    FacetSample sample;
    RatedMesh::Making sampled = making(facets_);
    sampled.weights = exposed_;
    if (facets_.size() > kSampledFacets) {
      sample = sample_of(facets_, exposed_, kSampledFacets);
      sampled.facets = sample.facets;
      sampled.weights = sample.weights;
    }
    const RatedMesh mesh(sampled);
    OrientationRating rating(mesh, request_, OrientationRating::Mesh::Sample);
    Ranked rated;
    for (const Direction& up : candidates) {
      if (stop_.stop_requested()) break;
      rated.push_back(rating.rate(up));
    }
    steps_ += rating.steps();
    return rated;
  }

  // Rates the best directions by the sample, and as drawn or nearly so, by all facets. If none of them fits,
  // rates more until one does.
  Ranked rate_finalists(std::span<const OrientationFigures> sampled) {
    RatedMesh::Making whole = making(facets_);
    whole.weights = exposed_;
    const RatedMesh mesh(whole);
    OrientationRating rating(mesh, request_, OrientationRating::Mesh::Whole);
    Ranked rated;
    for (const OrientationFigures& each : sampled)
      if (each.up.z > kCosNearlyLevel) rated.push_back(rating.rate(each.up));
    bool one_fits = std::ranges::any_of(rated, &OrientationFigures::fits);
    for (const OrientationFigures& each : sampled) {
      if (stop_.stop_requested() ||
          (rated.size() >= finalists_of(facets_.size()) && (one_fits || !each.fits)))
        break;
      if (each.up.z > kCosNearlyLevel) continue;
      rated.push_back(rating.rate(each.up));
      one_fits = one_fits || rated.back().fits;
    }
    steps_ += rating.steps();
    return rated;
  }

  // Returns the directions to try: as drawn, with the base level, the best ones, and the best of those in
  // which the model stands, because the rating is kind to directions in which nothing lies flat.
  [[nodiscard]] static Ranked to_try(const Ranked& rated, std::size_t facets) {
    Ranked chosen{*std::ranges::find(rated, kAsDrawn, &OrientationFigures::up)};
    const auto add = [&](std::size_t most, bool standing) {
      for (const OrientationFigures& each : rated) {
        const bool may_be = each.fits == rated.front().fits && (each.stands || !standing);
        const bool is_new = std::ranges::find(chosen, each.up, &OrientationFigures::up) == chosen.end();
        if (chosen.size() < most && may_be && is_new) chosen.push_back(each);
      }
    };
    for (const OrientationFigures& each : rated)
      if (each.up.z > kCosNearlyLevel && each.stands && each.up != kAsDrawn) chosen.push_back(each);
    add(4, true);
    add(trials_of(facets), false);
    return chosen;
  }

  // Tries the directions as long as they may be better than the best one so far.
  OrientationChoice try_best(const Ranked& rated) {
    OrientationChoice choice;
    double best = std::numeric_limits<double>::infinity();
    for (const OrientationFigures& figures : to_try(rated, facets_.size())) {
      OrientationFigures at_best = figures;
      at_best.contacts /= kMostOverestimated;
      at_best.support_mm3 /= kMostOverestimated;
      OrientationFigures trial = figures;
      const bool may_be_chosen = !choice.own_supports || figures.up.z > kCosNearlyLevel;
      if (may_be_chosen && score_of(at_best, request_.weights, worst_) < best)
        trial = try_orientation(facets_, figures, request_, stop_);
      if (stop_.stop_requested()) break;
      if (request_.keep_own_supports && figures.up == kAsDrawn && trial.tried &&
          carries_supports_as_drawn()) {
        choice.own_supports = true;
        trial.contacts = trial.support_mm3 = 0;  // the print adds none
      }
      if (trial.tried) best = std::min(best, score_of(trial, request_.weights, worst_));
      choice.ranked.push_back(trial);
    }
    return choice;
  }

  [[nodiscard]] bool carries_supports_as_drawn() const {
    std::vector<Facet> copy(facets_.begin(), facets_.end());
    orient(copy, {.scale = request_.scale});
    const auto model = std::make_shared<const HeightIndex>(std::move(copy));
    return Millimeters{model->bounds().size_z()} <= kHighestSweep &&
           carries_supports(model, request_.supports, stop_);
  }

  std::span<const Facet> facets_;
  const OrientationRequest& request_;
  const std::stop_token& stop_;
  std::vector<double> exposed_;  // by facet, or empty: see exposed_parts()
  Worst worst_;
  std::uint64_t steps_ = 0;
};

}  // namespace

std::size_t finalists_of(std::size_t facets) {
  constexpr std::size_t kFacetsRated = 8'000'000, kFewest = 6, kMost = 24;
  return std::clamp(kFacetsRated / std::max<std::size_t>(facets, 1), kFewest, kMost);
}

std::size_t trials_of(std::size_t facets) {
  return facets > kSampledFacets ? 8 : 12;
}

std::optional<OrientationChoice> choose_orientation(std::span<const Facet> facets,
                                                    const OrientationRequest& request,
                                                    const std::stop_token& stop) {
  expects(!facets.empty() && facets.size() < kMaxFacets, "there are facets, and fewer than 2^30");
  const HeightIndex model({facets.begin(), facets.end()});
  return Choosing(model, request, stop).choose();
}

}  // namespace contourd
