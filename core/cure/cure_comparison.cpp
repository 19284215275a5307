#include "core/cure/cure_comparison.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numeric>
#include <optional>
#include <utility>

#include "core/contract/expects.hpp"
#include "core/cure/pixel_light.hpp"
#include "core/cure/ray_sort.hpp"
#include "core/cure/removed_stretches.hpp"

namespace contourd {
namespace {

constexpr float kFacesUpOrDown = 0.5F;   // sine of 30 degrees
constexpr float kFacesLine = 0.7071F;    // cosine of 45 degrees
constexpr double kOnPlateMm = 0.001;     // rounding of a file's coordinates
constexpr std::int32_t kWallReach = 20;  // pixels in which the part's wall is looked for
// Steepness of surfaces that are not measured: those of supports, of cavities and drain holes, and the ends
// of models that go on above.
constexpr float kNotMeasured = 1e-3F;

// Returns the crossings of a model on vertical lines, as far up as it was printed.
std::vector<RayCrossing> end_at(const PrintedUpTo& up_to, std::vector<RayCrossing> crossings,
                                StopCheck& check) {
  const std::vector<RayStretch> stretches = stretches_within(std::move(crossings), check);
  std::vector<RayCrossing> printed;
  for (const RayStretch& stretch : stretches) {
    if (static_cast<double>(stretch.from.at) > up_to.mask_mm) continue;
    printed.push_back(stretch.from);
    const bool ends = static_cast<double>(stretch.to.at) > up_to.top_mm;
    printed.push_back(ends ? RayCrossing{stretch.ray, static_cast<float>(up_to.top_mm), kNotMeasured}
                           : stretch.to);
  }
  return printed;
}

// Returns the crossings of a model's surface, less its holes.
std::vector<RayCrossing> whole_crossings_of(const PlateModel& model, const Rays& rays, StopCheck& check) {
  std::vector<RayCrossing> crossings = cross_surface(std::span(&model, 1), rays, check);
  if (!model.holes) return crossings;
  std::vector<RayStretch> stretches = stretches_within(std::move(crossings), check);
  stretches = without_holes(std::move(stretches), model, rays, kNotMeasured, check);
  std::vector<RayCrossing> left;
  for (const RayStretch& stretch : stretches)
    left.insert(left.end(), {stretch.from, stretch.to});
  return left;
}

std::vector<RayCrossing> crossings_of(const ComparedModel& compared, const Rays& rays, StopCheck& check) {
  std::vector<RayCrossing> crossings = whole_crossings_of(compared.model, rays, check);
  if (std::isinf(compared.up_to.top_mm)) return crossings;
  if (rays.axis == RayAxis::Z) return end_at(compared.up_to, std::move(crossings), check);
  const auto lines =
      static_cast<std::size_t>(rays.axis == RayAxis::X ? rays.window.rows : rays.window.columns);
  std::erase_if(crossings, [&](const RayCrossing& crossing) {
    return rays.heights_mm[crossing.ray / lines] > compared.up_to.top_mm;
  });
  return crossings;
}

std::vector<RayCrossing> all_crossings(std::span<const ComparedModel> models,
                                       std::span<const ComparedModel> supports, const Rays& rays,
                                       StopCheck& check) {
  std::vector<RayCrossing> crossings;
  for (const ComparedModel& model : models) {
    std::vector<RayCrossing> more = crossings_of(model, rays, check);
    if (crossings.empty()) {
      crossings = std::move(more);  // most prints have one model
    } else {
      crossings.insert(crossings.end(), more.begin(), more.end());
    }
  }
  for (const ComparedModel& support : supports) {
    for (RayCrossing crossing : crossings_of(support, rays, check)) {
      crossing.steepness = std::copysign(kNotMeasured, crossing.steepness);
      crossings.push_back(crossing);
    }
  }
  return crossings;
}

std::vector<RayStretch> vertical_stretches(std::span<const ComparedModel> models,
                                           std::span<const ComparedModel> supports, const PixelWindow& window,
                                           StopCheck& check) {
  return stretches_within(all_crossings(models, supports, {RayAxis::Z, window, {}}, check), check);
}

// Returns numbers of layers at equal distances, rising.
std::vector<std::size_t> sample(std::size_t layers, std::size_t most) {
  const std::size_t step = std::max<std::size_t>(1, (layers + most - 1) / most);
  std::vector<std::size_t> sampled;
  for (std::size_t layer = step / 2; layer < layers; layer += step)
    sampled.push_back(layer);
  return sampled;
}

}  // namespace

CureComparison::CureComparison(std::span<const ComparedModel> models, std::span<const ComparedModel> supports,
                               const DisplayGeometry& display, const PixelWindow& window,
                               std::span<const LayerDose> layers, std::function<bool()> is_stopped)
    : check_(std::move(is_stopped)),
      display_(display),
      window_(window),
      pixel_mm_(to_millimeters(display.pixel_pitch).count()),
      layers_(layers.begin(), layers.end()),
      model_(vertical_stretches(models, supports, window, check_)),
      supports_(vertical_stretches(supports, std::span<const ComparedModel>(), window, check_)),
      wall_layers_(sample(layers.size(), kWallLayers)),
      layers_left_(layers.size()),
      solid_until_(window.pixels()) {
  expects(std::ranges::is_sorted(layers, {}, &LayerDose::top), "the layers rise");
  std::vector<double> heights;
  for (const std::size_t layer : wall_layers_)
    heights.push_back(in_mm(layers_[layer].top - layers_[layer].thickness / 2));
  walls_[0].axis = RayAxis::X;
  walls_[1].axis = RayAxis::Y;
  for (Walls& walls : walls_) {
    // The stretches' ends: surfaces within other bodies are no walls.
    for (const RayStretch& stretch :
         stretches_within(all_crossings(models, supports, {walls.axis, window, heights}, check_), check_)) {
      walls.crossings.push_back(stretch.from);
      walls.crossings.push_back(stretch.to);
    }
  }
}

void CureComparison::add_layer(std::size_t layer, const CuredLayers& cured, std::span<const float> dose) {
  expects(layer + 1 == layers_left_ && dose.size() == solid_until_.size(),
          "the layer is the next one below, with a dose for each pixel");
  --layers_left_;
  const LayerDose& of_layer = layers_[layer];
  const auto top = static_cast<float>(cured.solid_top(of_layer).count());
  if (top <= 0) return;  // in the dead zone on the plate
  const double thickness = in_mm(of_layer.thickness);
  // From this dose on, the layer is solid down to its bottom, whatever the rounding.
  const float whole = 1.0001F * static_cast<float>(cured.dose_at_top(to_millimeters(of_layer.thickness)));
  const bool ends = top <= static_cast<float>(thickness);  // at the plate
  constexpr std::size_t kBlock = 64;
  for (std::size_t first = 0; first < dose.size(); first += kBlock) {
    const std::size_t end = std::min(first + kBlock, dose.size());
    if (!ends && goes_on(first, end, dose, whole)) continue;
    for (std::size_t pixel = first; pixel < end; ++pixel) {
      float& until = solid_until_[pixel];
      const auto number = static_cast<std::uint32_t>(pixel);
      const bool solid = dose[pixel] >= 1;
      if (!solid && until == 0) continue;
      if (!solid) {
        cured_.push_back({number, top, std::exchange(until, 0.0F)});
        continue;
      }
      if (until == 0) until = top;
      if (dose[pixel] >= whole && !ends) continue;
      const double solid_mm = cured.solid_thickness(of_layer, dose[pixel]).count();
      if (solid_mm < thickness) {
        cured_.push_back(
            {number, std::max(top - static_cast<float>(solid_mm), 0.0F), std::exchange(until, 0.0F)});
      } else if (ends) {
        cured_.push_back({number, 0.0F, std::exchange(until, 0.0F)});
      }
    }
  }
  const auto height = std::ranges::lower_bound(wall_layers_, layer);
  if (height == wall_layers_.end() || *height != layer) return;
  for (Walls& walls : walls_)
    measure_walls(walls, static_cast<std::size_t>(height - wall_layers_.begin()), cured, layer, dose);
}

// True if each of these pixels is liquid below liquid, or solid throughout the layer below solid.
bool CureComparison::goes_on(std::size_t first, std::size_t end, std::span<const float> dose,
                             float whole) const {
  const float* const until = solid_until_.data();
  unsigned all = 1;
  for (std::size_t pixel = first; pixel < end; ++pixel) {
    const float of = dose[pixel];
    all &= (static_cast<unsigned>(of < 1) & static_cast<unsigned>(until[pixel] == 0)) |
           (static_cast<unsigned>(of >= whole) & static_cast<unsigned>(until[pixel] != 0));
  }
  return all != 0;
}

void CureComparison::measure_walls(Walls& walls, std::size_t height, const CuredLayers& cured,
                                   std::size_t layer, std::span<const float> dose) {
  const bool along_rows = walls.axis == RayAxis::X;
  const std::int32_t first = along_rows ? window_.column : window_.row;
  const std::int32_t length = along_rows ? window_.columns : window_.rows;
  const auto lines = static_cast<std::uint32_t>(along_rows ? window_.rows : window_.columns);
  const double middle_mm = in_mm(layers_[layer].top - layers_[layer].thickness / 2);
  const double below_top = cured.solid_top(layers_[layer]).count() - middle_mm;
  const double least = cured.dose_at_top(Millimeters{below_top});
  const auto begin = std::ranges::lower_bound(walls.crossings, height * lines, {}, &RayCrossing::ray);
  for (auto crossing = begin; crossing != walls.crossings.end() && crossing->ray < (height + 1) * lines;
       ++crossing) {
    if (std::abs(crossing->steepness) < kFacesLine) continue;
    const auto line = static_cast<std::size_t>(crossing->ray - height * lines);
    const auto pixel_of = [&](std::int32_t at) {
      const auto on_line = static_cast<std::size_t>(at);
      const auto columns = static_cast<std::size_t>(window_.columns);
      return along_rows ? line * columns + on_line : on_line * columns + line;
    };
    const bool enters = crossing->steepness < 0;
    // Pixels' middles are at at + 0.5; the wall is looked for between the middles of at and at + 1.
    const double model_at = static_cast<double>(crossing->at) - first - 0.5;
    std::optional<double> nearest;
    if (model_at < 0 || model_at > length - 1) continue;  // beside the display
    const auto nearby = static_cast<std::int32_t>(std::floor(model_at));
    for (std::int32_t at = std::max(0, nearby - kWallReach); at <= std::min(length - 2, nearby + kWallReach);
         ++at) {
      const double here = static_cast<double>(dose[pixel_of(at)]);
      const double next = static_cast<double>(dose[pixel_of(at + 1)]);
      if ((enters ? next : here) < least || (enters ? here : next) >= least) continue;
      const double part = enters ? 1 - wall_between(next, here, least) : wall_between(here, next, least);
      const double found = at + part;
      if (!nearest || std::abs(found - model_at) < std::abs(*nearest - model_at)) nearest = found;
    }
    if (!nearest) {
      ++walls.missing;
      continue;
    }
    const double outwards = (enters ? model_at - *nearest : *nearest - model_at) * pixel_mm_ *
                            static_cast<double>(std::abs(crossing->steepness));
    const std::int32_t at = std::clamp(nearby, 0, length - 1);
    walls.distances.push_back({static_cast<float>(outwards * 1000), static_cast<std::uint32_t>(pixel_of(at)),
                               static_cast<float>(middle_mm)});
  }
}

CureFigures CureComparison::figures() {
  expects(layers_left_ == 0, "all layers were added");
  sort_by_ray(
      cured_, &Stretch::pixel, [](const Stretch& a, const Stretch& b) { return a.from < b.from; }, check_);
  auto model = model_.begin();
  auto cured = cured_.begin();
  while (model != model_.end() || cured != cured_.end()) {
    const std::uint32_t pixel = std::min(model == model_.end() ? UINT32_MAX : model->ray,
                                         cured == cured_.end() ? UINT32_MAX : cured->pixel);
    const auto model_end =
        std::find_if(model, model_.end(), [&](const RayStretch& each) { return each.ray != pixel; });
    const auto cured_end =
        std::find_if(cured, cured_.end(), [&](const Stretch& each) { return each.pixel != pixel; });
    compare_column({model, model_end}, {cured, cured_end});
    check_.spend(static_cast<std::size_t>(model_end - model) *
                 (1 + static_cast<std::size_t>(cured_end - cured)));
    model = model_end;
    cured = cured_end;
  }
  figures_.undersides = summary(std::move(undersides_.distances), undersides_.missing);
  figures_.tops = summary(std::move(tops_.distances), tops_.missing);
  std::vector<Distance> walls = std::move(walls_[0].distances);
  std::ranges::move(walls_[1].distances, std::back_inserter(walls));
  figures_.walls = summary(std::move(walls), walls_[0].missing + walls_[1].missing);
  for (const SurfaceDistances* each : {&figures_.undersides, &figures_.tops, &figures_.walls}) {
    if (each->places == 0) continue;
    figures_.section = section(*each);
    break;
  }
  return figures_;
}

void CureComparison::compare_column(std::span<const RayStretch> model, std::span<const Stretch> cured) {
  const double pixel_mm2 = pixel_mm_ * pixel_mm_;
  double in_model = 0, in_both = 0, in_cured = 0;
  for (const Stretch& solid : cured)
    in_cured += static_cast<double>(solid.to) - static_cast<double>(solid.from);
  std::optional<double> below;  // top of the model's stretch below
  for (std::size_t i = 0; i < model.size(); ++i) {
    const RayStretch& stretch = model[i];
    const double from = static_cast<double>(stretch.from.at), to = static_cast<double>(stretch.to.at);
    in_model += to - from;
    const Stretch *lowest = nullptr, *highest = nullptr;
    for (const Stretch& solid : cured) {
      const double both =
          std::min(to, static_cast<double>(solid.to)) - std::max(from, static_cast<double>(solid.from));
      if (both <= 0) continue;
      in_both += both;
      if (lowest == nullptr) lowest = &solid;
      highest = &solid;
    }
    const bool measured = std::abs(stretch.from.steepness) >= kFacesUpOrDown && from > kOnPlateMm;
    if (lowest == nullptr) {
      if (measured) ++undersides_.missing;
      if (std::abs(stretch.to.steepness) >= kFacesUpOrDown) ++tops_.missing;
    } else {
      const bool closes = below && static_cast<double>(lowest->from) < *below;
      const double bottom = closes ? *below : static_cast<double>(lowest->from);
      if (measured) compare_end(stretch.from, from - bottom, undersides_.distances);
      // A top below a closed gap is no surface of the part; its gap counts as closed.
      const bool is_closed = i + 1 < model.size() && highest->to > model[i + 1].from.at;
      if (!is_closed) compare_end(stretch.to, static_cast<double>(highest->to) - to, tops_.distances);
      if (closes && !is_beside_support(stretch.ray, *below, from)) {
        figures_.closed_mm2 += pixel_mm2;
        if (from - *below > figures_.tallest_closed_mm) {
          figures_.tallest_closed_mm = from - *below;
          figures_.closed = place(stretch.ray, *below);
        }
      }
    }
    below = to;
  }
  figures_.model_mm3 += in_model * pixel_mm2;
  figures_.too_much_mm3 += (in_cured - in_both) * pixel_mm2;
  figures_.too_little_mm3 += (in_model - in_both) * pixel_mm2;
}

// True if a support fills a pixel nearby, or this one, at a height of the gap: its light, too, closes the
// gap.
bool CureComparison::is_beside_support(std::uint32_t pixel, double from_mm, double to_mm) const {
  constexpr std::int32_t kNearby = 2;  // pixels: a support's grey edge, and the pixel beside
  const std::int32_t row = static_cast<std::int32_t>(pixel) / window_.columns;
  const std::int32_t column = static_cast<std::int32_t>(pixel) % window_.columns;
  const std::int32_t last = std::min(column + kNearby, window_.columns - 1);
  for (std::int32_t y = std::max(0, row - kNearby); y <= std::min(row + kNearby, window_.rows - 1); ++y) {
    const auto ray = [&](std::int32_t x) { return static_cast<std::uint32_t>(y * window_.columns + x); };
    auto each = std::ranges::lower_bound(supports_, ray(std::max(0, column - kNearby)), {}, &RayStretch::ray);
    for (; each != supports_.end() && each->ray <= ray(last); ++each)
      if (static_cast<double>(each->from.at) <= to_mm && static_cast<double>(each->to.at) >= from_mm)
        return true;
  }
  return false;
}

void CureComparison::compare_end(const RayCrossing& end, double outwards_mm,
                                 std::vector<Distance>& distances) {
  const float steepness = std::abs(end.steepness);
  if (steepness < kFacesUpOrDown) return;
  distances.push_back({static_cast<float>(outwards_mm * 1000) * steepness, end.ray, end.at});
}

SurfaceDistances CureComparison::summary(std::vector<Distance> distances, std::uint64_t missing) const {
  SurfaceDistances figures{.places = distances.size(), .missing = missing};
  if (distances.empty()) return figures;
  const auto size = [](const Distance& distance) { return std::abs(distance.um); };
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::ranges::nth_element(distances, middle, {}, &Distance::um);
  figures.median_um = static_cast<double>(middle->um);
  const auto most = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() * 95 / 100);
  std::ranges::nth_element(distances, most, {}, size);
  figures.p95_um = static_cast<double>(size(*most));
  const auto worst = std::ranges::max_element(distances, {}, size);
  figures.worst_um = static_cast<double>(worst->um);
  figures.worst = place(worst->pixel, static_cast<double>(worst->height_mm));
  figures.bins = bins_of(distances);
  return figures;
}

// Counts at least one distance, and sorts them in part.
DistanceBins CureComparison::bins_of(std::vector<Distance>& distances) {
  const auto at = [&](std::size_t rank) {
    const auto place = distances.begin() + static_cast<std::ptrdiff_t>(rank);
    std::ranges::nth_element(distances, place, {}, &Distance::um);
    return static_cast<double>(place->um);
  };
  const std::size_t beyond = distances.size() / 400;
  const double low = at(beyond), high = at(distances.size() - 1 - beyond);
  constexpr double kMostBins = 60;
  DistanceBins bins{.width_um = 0.1};
  for (std::size_t step = 0; (high - low) / bins.width_um > kMostBins - 2; ++step)
    bins.width_um *= std::array{2.0, 2.5, 2.0}[step % 3];  // 1, 2 and 5 times a power of ten
  const auto bin_of = [&](double um) { return std::floor(um / bins.width_um + 0.5); };
  bins.first_um = bin_of(low) * bins.width_um;
  bins.places.resize(static_cast<std::size_t>(bin_of(high) - bin_of(low)) + 1);
  for (const Distance& distance : distances) {
    const double um = std::clamp(static_cast<double>(distance.um), low, high);
    ++bins.places[static_cast<std::size_t>(bin_of(um) - bin_of(low))];
  }
  return bins;
}

// Reads the sorted stretches of model and part.
CureSection CureComparison::section(const SurfaceDistances& through) const {
  CureSection section{through.worst, through.worst_um, pixel_mm_};
  const double row_at = PixelMap::true_scale(display_, {0, 0}).to_pixels(through.worst.plate_mm).y;
  const std::int32_t row =
      std::clamp(static_cast<std::int32_t>(std::floor(row_at)) - window_.row, 0, window_.rows - 1);
  const auto columns = static_cast<std::uint32_t>(window_.columns);
  const std::uint32_t first = static_cast<std::uint32_t>(row) * columns;
  section.first_x_mm = place(first, 0).plate_mm.x;
  section.step_mm = display_.mirror_x ? -pixel_mm_ : pixel_mm_;
  for (auto each = std::ranges::lower_bound(model_, first, {}, &RayStretch::ray);
       each != model_.end() && each->ray < first + columns; ++each)
    section.model.push_back(
        {each->ray - first, static_cast<double>(each->from.at), static_cast<double>(each->to.at)});
  for (auto each = std::ranges::lower_bound(cured_, first, {}, &Stretch::pixel);
       each != cured_.end() && each->pixel < first + columns; ++each)
    section.cured.push_back(
        {each->pixel - first, static_cast<double>(each->from), static_cast<double>(each->to)});
  return section;
}

CurePlace CureComparison::place(std::uint32_t pixel, double height_mm) const {
  const auto columns = static_cast<std::uint32_t>(window_.columns);
  const std::uint32_t column = pixel % columns, row = pixel / columns;
  const PixelPoint at{window_.column + static_cast<double>(column) + 0.5,
                      window_.row + static_cast<double>(row) + 0.5};
  return {on_plate(display_, at), height_mm};
}

}  // namespace contourd
