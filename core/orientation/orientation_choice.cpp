#include "core/orientation/orientation_choice.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "core/contract/expects.hpp"
#include "core/model/mesh_report.hpp"
#include "core/model/sine_cosine.hpp"
#include "core/orientation/orientation_rating.hpp"
#include "core/orientation/rated_mesh.hpp"

namespace contourd {
namespace {

constexpr Direction kAsDrawn{0, 0, 1};
// A model is turned only if another direction is better by this part of the sum of all weights.
constexpr double kWorthTurning = 0.05;

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

// Moves the direction to be printed to the front.
void choose(std::vector<OrientationFigures>& ranked, const OrientationWeights& weights) {
  const auto drawn = std::ranges::find(ranked, kAsDrawn, &OrientationFigures::up);
  const double all = weights.support + weights.contacts + weights.peel + weights.height + weights.standing;
  const bool may_stay = drawn->fits || !ranked.front().fits;
  if (may_stay && drawn->score <= ranked.front().score + kWorthTurning * all)
    std::rotate(ranked.begin(), drawn, drawn + 1);
}

class Choosing {
 public:
  Choosing(std::span<const Facet> facets, const OrientationRequest& request, const std::stop_token& stop)
      : facets_(facets),
        request_(request),
        stop_(stop),
        inside_out_(enclosed_volume(facets, bounds_of(facets)).inside_out()) {}

  std::optional<OrientationChoice> choose() {
    const std::vector<Direction> candidates = candidate_directions(facets_);
    std::vector<OrientationFigures> sampled = rate_by_sample(candidates);
    if (stop_.stop_requested()) return std::nullopt;
    Worst worst;
    for (const OrientationFigures& figures : sampled)
      worst.take(figures);
    rank(sampled, request_.weights, worst);
    OrientationChoice choice;
    choice.tried = static_cast<std::uint32_t>(candidates.size());
    choice.ranked = rate_finalists(sampled);
    if (stop_.stop_requested()) return std::nullopt;
    choice.steps = steps_;
    for (const OrientationFigures& figures : choice.ranked)
      worst.take(figures);
    rank(choice.ranked, request_.weights, worst);
    contourd::choose(choice.ranked, request_.weights);
    return choice;
  }

 private:
  [[nodiscard]] RatedMesh::Making making(std::span<const Facet> facets) const {
    const Scale& scale = request_.scale;
    // Converted to the model's own millimetres.
    const double cell_mm = kContactCellMm / std::max({scale.x, scale.y, scale.z});
    return {
        .facets = facets, .inside_out = inside_out_, .cell_mm = cell_mm, .keep_clean = request_.keep_clean};
  }

  std::vector<OrientationFigures> rate_by_sample(std::span<const Direction> candidates) {
    FacetSample sample;
    RatedMesh::Making sampled = making(facets_);
    if (facets_.size() > kSampledFacets) {
      sample = sample_of(facets_, kSampledFacets);
      sampled.facets = sample.facets;
      sampled.weights = sample.weights;
    }
    const RatedMesh mesh(sampled);
    OrientationRating rating(mesh, request_, OrientationRating::Mesh::Sample);
    std::vector<OrientationFigures> rated;
    for (const Direction& up : candidates) {
      if (stop_.stop_requested()) break;
      rated.push_back(rating.rate(up));
    }
    steps_ += rating.steps();
    return rated;
  }

  // Rates the best directions by the sample, and as drawn, by all facets. If none of them fits, rates more
  // until one does.
  std::vector<OrientationFigures> rate_finalists(std::span<const OrientationFigures> sampled) {
    const RatedMesh mesh(making(facets_));
    OrientationRating rating(mesh, request_, OrientationRating::Mesh::Whole);
    std::vector<OrientationFigures> rated{rating.rate(kAsDrawn)};
    bool one_fits = rated.front().fits;
    for (const OrientationFigures& each : sampled) {
      if (stop_.stop_requested() ||
          (rated.size() >= finalists_of(facets_.size()) && (one_fits || !each.fits)))
        break;
      if (each.up == kAsDrawn) continue;
      rated.push_back(rating.rate(each.up));
      one_fits = one_fits || rated.back().fits;
    }
    steps_ += rating.steps();
    return rated;
  }

  std::span<const Facet> facets_;
  const OrientationRequest& request_;
  const std::stop_token& stop_;
  bool inside_out_;
  std::uint64_t steps_ = 0;
};

constexpr double kCosLeastApart = 0.99863;  // 3 degrees

// Facets whose normals lie in the same cell of this grid, some 2 degrees wide, are taken for one face.
constexpr int kNormalCells = 32;
constexpr std::size_t kCellsAlong = 2 * kNormalCells + 1;

void add(std::vector<Direction>& directions, const Direction& candidate) {
  const bool is_new = std::ranges::none_of(
      directions, [&](const Direction& other) { return dot(candidate, other) > kCosLeastApart; });
  if (is_new) directions.push_back(candidate);
}

std::size_t cell_of(const Direction& normal) {
  const auto along = [](double part) {
    return static_cast<std::size_t>(std::lround(part * kNormalCells) + kNormalCells);
  };
  return (along(normal.x) * kCellsAlong + along(normal.y)) * kCellsAlong + along(normal.z);
}

Direction scaled(const Direction& v, double factor) {
  return {v.x * factor, v.y * factor, v.z * factor};
}

// Returns the areas of flat faces, largest first. A curved surface is spread over many cells, each with a
// small area.
std::vector<Direction> flat_faces(std::span<const Facet> facets) {
  std::vector<Direction> cells(kCellsAlong * kCellsAlong * kCellsAlong, Direction{0, 0, 0});
  for (const Facet& facet : facets) {
    const Direction area = area_of(facet);
    const double size = length_of(area);
    if (!(size > 0)) continue;
    Direction& sum = cells[cell_of(scaled(area, 1 / size))];
    sum = {sum.x + area.x, sum.y + area.y, sum.z + area.z};
  }
  std::erase_if(cells, [](const Direction& area) { return !(length_of(area) > 0); });
  std::ranges::stable_sort(cells, std::ranges::greater{}, length_of);
  return cells;
}

// Adds directions on a spiral from pole to pole, each the golden angle further round than the previous one.
void add_spread(std::vector<Direction>& directions) {
  constexpr double kGoldenAngleDeg = 137.50776405003785;
  for (std::size_t i = 0; i < kSpreadDirections; ++i) {
    const double z = 1 - (2 * static_cast<double>(i) + 1) / static_cast<double>(kSpreadDirections);
    const double across = std::sqrt(1 - z * z);
    const auto [sine, cosine] = sine_cosine(std::fmod(static_cast<double>(i) * kGoldenAngleDeg, 360.0));
    add(directions, {across * cosine, across * sine, z});
  }
}

}  // namespace

std::size_t finalists_of(std::size_t facets) {
  constexpr std::size_t kFacetsRated = 8'000'000, kFewest = 6, kMost = 24;
  return std::clamp(kFacetsRated / std::max<std::size_t>(facets, 1), kFewest, kMost);
}

std::optional<OrientationChoice> choose_orientation(std::span<const Facet> facets,
                                                    const OrientationRequest& request,
                                                    const std::stop_token& stop) {
  expects(!facets.empty() && facets.size() < kMaxFacets, "there are facets, and fewer than 2^30");
  return Choosing(facets, request, stop).choose();
}

std::vector<Direction> candidate_directions(std::span<const Facet> facets) {
  std::vector<Direction> directions{{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}};
  for (const Direction& area : flat_faces(facets)) {
    if (directions.size() == 6 + kMostFaceDirections) break;
    add(directions, scaled(area, -1 / length_of(area)));
  }
  add_spread(directions);
  return directions;
}

}  // namespace contourd
