#include "core/cure/underside_dimming.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "core/contract/expects.hpp"
#include "core/geometry/mask_budget.hpp"

namespace contourd {
namespace {

// Undersides steeper than 63 degrees are walls.
constexpr double kSteepest = 2;  // tangent
constexpr double kSteepestCosine = 0.447;
constexpr double kHeightStep = 1e-3;  // mm: the light is computed for each micrometre
constexpr std::size_t kLayerCounts = UndersideDimming::kMostAhead + 3;  // none, some, and an endless solid's
constexpr std::size_t kUnknown = std::numeric_limits<std::size_t>::max();

double middle_mm(const LayerDose& layer) {
  return in_mm(layer.top) - in_mm(layer.thickness) / 2;
}

// Returns the number of layers whose light reaches an underside.
std::size_t layers_ahead(std::span<const LayerDose> layers, const WorkingCurve& curve) {
  constexpr double kFalloff = 5;  // penetration depths: to 0.7 %
  double thinnest = std::numeric_limits<double>::infinity();
  for (const LayerDose& layer : layers)
    thinnest = std::min(thinnest, in_mm(layer.thickness));
  const double count = std::ceil(kFalloff * to_millimeters(curve.penetration_depth).count() / thinnest);
  return static_cast<std::size_t>(std::clamp(count, 1.0, static_cast<double>(UndersideDimming::kMostAhead)));
}

// Returns how many of a solid's layers may get less than all their light. Of a part that leans, each layer
// lies beside the one beneath; with a third of the layers and one more lit, their light still overlaps.
std::size_t most_dimmed(std::size_t layers) {
  const std::size_t kept = (layers + 2) / 3 + 1;
  return layers > kept ? layers - kept : 0;
}

// Returns by how many pixels the masks reach beyond the models, and two more.
std::int32_t margin_of(const EngineSettings& settings) {
  const double grown = settings.compensation.growth.count() / settings.display.pixel_pitch.count();
  return 2 + static_cast<std::int32_t>(std::ceil(std::max(grown, 0.0)));
}

}  // namespace

void dim(std::span<const DimmedPixel> pixels, Mask& light) {
  const auto width = static_cast<std::uint32_t>(light.width().count());
  for (const DimmedPixel& dimmed : pixels) {
    std::uint8_t& grey = light.row(static_cast<std::int32_t>(dimmed.pixel / width))[dimmed.pixel % width];
    grey = static_cast<std::uint8_t>((grey * dimmed.share + 127) / 255);
  }
}

SolidLight::SolidLight(const CureSettings& resin)
    : resin_(resin), loss_{resin.peel_memory, resin.oxygen_dose / resin.curve.critical_dose} {}

void SolidLight::begin(std::span<const LayerDose> layers) {
  expects(!layers.empty() && layers.size() <= UndersideDimming::kMostAhead + 1,
          "there are layers, but no more");
  layers_ = layers;
  const LayerDose& first = layers.front();
  const Nanometers bottom = first.top - first.thickness;
  bottom_mm_ = in_mm(bottom);
  // Most undersides lie between the cuts beneath and two layers above; others are computed one by one.
  lowest_mm_ = bottom_mm_ - in_mm(first.thickness);
  const LayerDose& highest = layers[std::min<std::size_t>(3, layers.size() - 1)];
  const auto steps = static_cast<std::size_t>((in_mm(highest.top) - lowest_mm_) / kHeightStep) + 2;
  known_.assign(steps * kLayerCounts, {kUnknown, 0});
  // Above the layers ahead, the last one repeats.
  constexpr double kFaintest = 1e-3;
  constexpr std::size_t kMostDoses = 3 * UndersideDimming::kMostAhead;
  const double depth_mm = to_millimeters(resin_.curve.penetration_depth).count();
  full_doses_.clear();
  Nanometers top = bottom;
  while (full_doses_.size() < layers.size() ||
         (full_doses_.back() > kFaintest && full_doses_.size() < kMostDoses)) {
    const LayerDose& layer = layers[std::min(full_doses_.size(), layers.size() - 1)];
    top += layer.thickness;
    full_doses_.push_back(layer.dose / resin_.curve.critical_dose *
                          std::exp(-in_mm(top - bottom) / depth_mm));
  }
}

UndersideLight SolidLight::of(const Solid& solid) {
  expects(!solid.coverage.empty() && solid.coverage.size() <= layers_.size(),
          "the solid has some of the layers");
  const double steps = std::max(0.0, std::round((solid.underside_mm - lowest_mm_) / kHeightStep));
  const Solid rounded{lowest_mm_ + steps * kHeightStep, solid.coverage, solid.is_endless};
  const std::size_t place = static_cast<std::size_t>(steps) * kLayerCounts +
                            (solid.is_endless ? kLayerCounts - 1 : solid.coverage.size());
  const bool is_full = std::ranges::all_of(solid.coverage, [](std::uint8_t grey) { return grey == 255; });
  if (!is_full || place >= known_.size()) return compute(rounded);
  if (known_[place].dark == kUnknown) known_[place] = compute(rounded);
  return known_[place];
}

UndersideLight SolidLight::compute(const Solid& solid) {
  const double depth_mm = to_millimeters(resin_.curve.penetration_depth).count();
  const double dead_zone_mm = to_millimeters(resin_.dead_zone).count();
  const double nearer = std::exp((solid.underside_mm - bottom_mm_) / depth_mm);
  const std::size_t count = solid.coverage.size();
  doses_.clear();
  for (std::size_t layer = 0; layer < (solid.is_endless ? full_doses_.size() : count); ++layer) {
    const double share = layer < count ? solid.coverage[layer] / 255.0 : 1;
    const bool is_above = layer >= count || in_mm(layers_[layer].top) - solid.underside_mm >= dead_zone_mm;
    doses_.push_back(is_above ? share * nearer * full_doses_[layer] : 0);
  }
  return underside_light(doses_, loss_, most_dimmed(count));
}

LayerPictures::Picture LayerPictures::of(const LayerDose& layer) {
  Picture picture(window_.pixels());
  MaskBudget spent = budget();
  if (engine_.mask_within(layer.top - layer.thickness + layer.thickness / 2, spent) == nullptr) return {};
  const std::uint8_t threshold = engine_.threshold();
  auto to = picture.begin();
  for (std::int32_t y = window_.row; y < window_.row + window_.rows; ++y) {
    const auto row = engine_.coverage().row(y).subspan(static_cast<std::size_t>(window_.column),
                                                       static_cast<std::size_t>(window_.columns));
    to = std::ranges::transform(row, to, [threshold](std::uint8_t grey) {
           return grey < threshold ? std::uint8_t{0} : grey;
         }).out;
  }
  return picture;
}

void ModelEntries::restart() {
  for (const Batch& batch : batches_)
    for (const RayCrossing& entry : batch.entries)
      lowest_mm_[entry.ray] = kNone;
  batches_.clear();
  range_ = RayRange{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
}

void ModelEntries::rise_to(std::span<const PlateModel> models, const RayRange& range, double walls_up_to_mm,
                           MaskBudget& budget) {
  expects(range.above_mm >= range_.above_mm && range.up_to_mm >= range_.up_to_mm, "the range rises");
  std::size_t count = 0;
  for (const Batch& batch : batches_) {
    for (const RayCrossing& entry : batch.entries)
      lowest_mm_[entry.ray] = kNone;
    count += batch.entries.size();
  }
  const RayRange unknown{std::max(range.above_mm, range_.up_to_mm), range.up_to_mm};
  if (count < window_.pixels() && unknown.above_mm < unknown.up_to_mm)
    batches_.push_back({unknown.up_to_mm, entries_between(models, window_, unknown, budget)});
  range_ = range;
  while (!batches_.empty() && batches_.front().up_to_mm <= range.above_mm)
    batches_.pop_front();
  const auto counts = [&](const RayCrossing& entry) {
    const auto at = static_cast<double>(entry.at);
    return at > range.above_mm &&
           (at <= walls_up_to_mm || static_cast<double>(entry.steepness) <= -kSteepestCosine);
  };
  for (const Batch& batch : batches_)
    for (const RayCrossing& entry : batch.entries)
      if (counts(entry)) lowest_mm_[entry.ray] = std::min(lowest_mm_[entry.ray], entry.at);
}

std::optional<double> ModelEntries::lowest_mm(std::size_t pixel) const {
  if (lowest_mm_[pixel] == kNone) return std::nullopt;
  return static_cast<double>(lowest_mm_[pixel]);
}

UndersideDimming::UndersideDimming(std::span<const PlateModel> models,
                                   std::shared_ptr<const SectionSource> supports,
                                   const EngineSettings& settings, const UndersideCure& cure)
    : window_(window_of(models, settings.display, margin_of(settings))),
      models_(ContourEngine(std::vector<PlateModel>(models.begin(), models.end()), settings), window_,
              cure.mask_budget),
      display_(settings.display),
      layers_(cure.layers),
      most_ahead_(layers_ahead(layers_, cure.resin.curve)),
      entries_(window_),
      light_(cure.resin) {
  expects(!layers_.empty() && std::ranges::is_sorted(layers_, {}, &LayerDose::top),
          "layers rise from the plate");
  if (supports)
    supports_.emplace(ContourEngine(std::vector<PlateModel>(), settings, std::move(supports)), window_,
                      cure.mask_budget);
  restart_before(0);
}

std::uint64_t UndersideDimming::most_memory(const DisplayGeometry& display, const UndersideCure& cure) {
  const auto pixels =
      static_cast<std::uint64_t>(display.width.count()) * static_cast<std::uint64_t>(display.height.count());
  // The layer beneath, this layer and those ahead; supports; heights and the list of their entries; masks of
  // two engines and of DimmedMasks.
  return pixels *
         (layers_ahead(cure.layers, cure.resin.curve) + 2 + 2 + sizeof(float) + 3 * sizeof(RayCrossing) + 6);
}

std::span<const DimmedPixel> UndersideDimming::dimmed(std::size_t layer) {
  expects(layer < layers_.size(), "the layer is one of the print's");
  if (layer == 0) return {};  // the layer stands on the plate; the masks ahead of other layers stay known
  const std::size_t dark = exclusions_at(layer);
  if (dark != dark_.known) leave_dark(dark);
  if (layer < layer_ || layer > layer_ + most_ahead_) restart_before(layer);
  while (layer_ < layer)
    advance();
  return dimmed_.pixels;
}

void UndersideDimming::exclude(std::size_t model, std::size_t copy,
                               std::shared_ptr<const SectionSource> supports, std::size_t layer) {
  expects(layer < layers_.size() && (dark_.exclusions.empty() || layer >= dark_.exclusions.back().layer),
          "the layer is one of the print's, and not beneath those of other exclusions");
  expects(model < models_.models().size() && copy < models_.models()[model].copies.size(),
          "there is such a copy");
  dark_.exclusions.push_back({layer, model, copy, std::move(supports)});
}

void UndersideDimming::include_all() {
  dark_.exclusions.clear();
  if (dark_.known > 0) leave_dark(0);
}

// Returns the number of exclusions that a print knows in this layer.
std::size_t UndersideDimming::exclusions_at(std::size_t layer) const {
  const auto end = std::ranges::upper_bound(dark_.exclusions, layer, {}, &Exclusion::layer);
  return static_cast<std::size_t>(end - dark_.exclusions.begin());
}

// Leaves dark what the first exclusions do, and forgets the pictures.
void UndersideDimming::leave_dark(std::size_t exclusions) {
  models_.engine().light_all();
  if (supports_) supports_->engine().light_all();
  for (const Exclusion& each : std::span(dark_.exclusions).first(exclusions)) {
    const Nanometers from = layers_[each.layer].top - layers_[each.layer].thickness;
    models_.engine().darken(each.model, each.copy, from);
    if (supports_ && each.supports) supports_->engine().replace_beside(each.supports, from);
  }
  dark_.known = exclusions;
  restart_before(0);
}

// Goes to a layer from which on all solids are found that are dimmed in `layer`.
void UndersideDimming::restart_before(std::size_t layer) {
  layer_ = layer > most_ahead_ ? layer - most_ahead_ : 0;
  undersides_.clear();
  dimmed_.are_found = true;
  dimmed_.pixels.clear();
  ahead_.clear();
  entries_.restart();
  if (supports_) supports_at_.here = supports_->of(layers_[layer_]);
}

void UndersideDimming::advance() {
  ++layer_;
  if (!ahead_.empty()) ahead_.pop_front();
  const std::size_t end = std::min(layer_ + most_ahead_ + 1, layers_.size());
  while (layer_ - 1 + ahead_.size() < end)
    ahead_.push_back(models_.of(layers_[layer_ - 1 + ahead_.size()]));
  if (supports_) {
    supports_at_.beneath = std::move(supports_at_.here);
    supports_at_.here = supports_->of(layers_[layer_]);
  }
  MaskBudget budget = models_.budget();
  find_entries(budget);
  light_.begin(std::span(layers_).subspan(layer_, end - layer_));
  dimmed_.are_found = has_pictures() && find_undersides(budget);
  list_dimmed();
}

// Finds where the line through the middle of a pixel enters the model that begins to be lit in this layer:
// above the cut beneath, and as high as an underside rises across a pixel.
void UndersideDimming::find_entries(MaskBudget& budget) {
  const double next_cut_mm =
      layer_ + 1 == layers_.size() ? in_mm(layers_[layer_].top) : middle_mm(layers_[layer_ + 1]);
  const double across_mm = std::numbers::sqrt2 * to_millimeters(display_.pixel_pitch).count();
  const double highest_mm = std::max(next_cut_mm, middle_mm(layers_[layer_]) + kSteepest * across_mm);
  entries_.rise_to(models_.models(), {middle_mm(layers_[layer_ - 1]), highest_mm}, next_cut_mm, budget);
}

// True if the pictures of this layer and the one beneath are known: otherwise sound parts could be taken for
// undersides.
bool UndersideDimming::has_pictures() const {
  return !ahead(layer_ - 1).empty() && !ahead(layer_).empty() &&
         (!supports_ || (!supports_at_.beneath.empty() && !supports_at_.here.empty()));
}

bool UndersideDimming::find_undersides(MaskBudget& budget) {
  const Picture &beneath = ahead(layer_ - 1), &here = ahead(layer_);
  const std::size_t first = undersides_.size();
  std::vector<std::size_t> rims;
  constexpr std::size_t kBlock = 64;  // most blocks have no underside
  for (std::size_t begin = 0; begin < here.size(); begin += kBlock) {
    const std::size_t end = std::min(begin + kBlock, here.size());
    unsigned begins = 0;
    for (std::size_t pixel = begin; pixel < end; ++pixel)
      begins |= static_cast<unsigned>(here[pixel] != 0) & static_cast<unsigned>(beneath[pixel] == 0);
    if (begins != 0 && !budget.spend(kBlock)) return false;
    for (std::size_t pixel = begin; begins != 0 && pixel < end; ++pixel) {
      if (here[pixel] == 0 || beneath[pixel] != 0) continue;
      if (here[pixel] < 255 || !entries_.lowest_mm(pixel)) {
        rims.push_back(pixel);
      } else if (const std::optional<Underside> found = underside_of(pixel)) {
        undersides_.push_back(*found);
      }
    }
  }
  find_rims(rims, first);
  return true;
}

// Returns a height above which a solid has ended whose pixel is dark from layer `end` on.
double UndersideDimming::top_of_solid_mm(std::size_t end) const {
  return end < layers_.size() ? middle_mm(layers_[end]) : in_mm(layers_.back().top);
}

std::optional<UndersideDimming::Underside> UndersideDimming::underside_of(std::size_t pixel) {
  column_.clear();
  if (supports_ && (supports_at_.beneath[pixel] != 0 || supports_at_.here[pixel] != 0)) return std::nullopt;
  const std::size_t end_ahead = layer_ - 1 + ahead_.size();
  for (std::size_t layer = layer_; layer < end_ahead && !ahead(layer).empty() && ahead(layer)[pixel] != 0;
       ++layer)
    column_.push_back(ahead(layer)[pixel]);
  const std::size_t end = layer_ + column_.size();
  const bool is_endless = end == end_ahead && end < layers_.size();
  double underside_mm = in_mm(layers_[layer_].top - layers_[layer_].thickness);
  const std::optional<double> entry_mm = entries_.lowest_mm(pixel);
  // An entry above the solid's top belongs to another solid.
  if (entry_mm && (is_endless || *entry_mm <= top_of_solid_mm(end))) underside_mm = *entry_mm;
  const UndersideLight light = light_.of({underside_mm, column_, is_endless});
  if (light == UndersideLight{}) return std::nullopt;
  const bool is_grey = light.next_share < 1;
  const std::size_t full_from = layer_ + light.dark + (is_grey ? 1 : 0);
  if (!is_wide(pixel, ahead(full_from))) return std::nullopt;
  return Underside{static_cast<std::uint32_t>(pixel), full_from,
                   is_grey ? static_cast<std::uint8_t>(light.next_share * 255 + 0.5) : std::uint8_t{0}};
}

void UndersideDimming::find_rims(std::span<const std::size_t> rims, std::size_t first) {
  const std::size_t end = undersides_.size(), columns = static_cast<std::size_t>(window_.columns);
  std::array<std::size_t, 3> next{first, first, first};  // in the row above, the rim's and the one below
  for (const std::size_t pixel : rims) {
    std::optional<Underside> beside;  // the one that is lit first
    for (std::size_t row = 0; row < next.size(); ++row) {
      const std::size_t middle = pixel + row * columns;  // of three pixels, one row too low
      while (next[row] < end && undersides_[next[row]].pixel + columns + 1 < middle)
        ++next[row];
      for (std::size_t i = next[row]; i < end && undersides_[i].pixel + columns <= middle + 1; ++i)
        if (!beside || undersides_[i].full_from < beside->full_from) beside = undersides_[i];
    }
    std::optional<Underside> rim = underside_of(pixel);
    if (beside && (!rim || rim->full_from < beside->full_from)) {
      const std::size_t full_from = std::min(beside->full_from, layer_ + most_dimmed(column_.size()));
      rim = {static_cast<std::uint32_t>(pixel), full_from, beside->next_share};
    }
    if (rim) undersides_.push_back(*rim);
  }
}

// True if the pixel belongs to a square of three by three pixels that are lit at least half.
bool UndersideDimming::is_wide(std::size_t pixel, const Picture& picture) const {
  const auto column = static_cast<std::int32_t>(pixel % static_cast<std::size_t>(window_.columns));
  const auto row = static_cast<std::int32_t>(pixel / static_cast<std::size_t>(window_.columns));
  const auto is_square = [&](std::int32_t middle_column, std::int32_t middle_row) {
    if (middle_column < 1 || middle_row < 1 || middle_column + 1 >= window_.columns ||
        middle_row + 1 >= window_.rows)
      return false;
    for (std::int32_t y = middle_row - 1; y <= middle_row + 1; ++y)
      for (std::int32_t x = middle_column - 1; x <= middle_column + 1; ++x)
        if (picture[static_cast<std::size_t>(y) * static_cast<std::size_t>(window_.columns) +
                    static_cast<std::size_t>(x)] < 128)
          return false;
    return true;
  };
  constexpr std::array kOffsets{0, -1, 1};  // most pixels are in the middle of such a square
  return std::ranges::any_of(kOffsets, [&](std::int32_t down) {
    return std::ranges::any_of(kOffsets,
                               [&](std::int32_t right) { return is_square(column + right, row + down); });
  });
}

void UndersideDimming::list_dimmed() {
  std::erase_if(undersides_, [&](const Underside& each) { return each.full_from <= layer_; });
  dimmed_.pixels.clear();
  if (supports_ && supports_at_.here.empty()) return;  // supports, wherever they are, keep their light
  const auto columns = static_cast<std::uint32_t>(window_.columns);
  for (const Underside& each : undersides_) {
    if (supports_ && supports_at_.here[each.pixel] != 0) continue;
    const std::uint32_t row = static_cast<std::uint32_t>(window_.row) + each.pixel / columns;
    const std::uint32_t column = static_cast<std::uint32_t>(window_.column) + each.pixel % columns;
    dimmed_.pixels.push_back({row * static_cast<std::uint32_t>(display_.width.count()) + column,
                              each.full_from == layer_ + 1 ? each.next_share : std::uint8_t{0}});
  }
}

DimmedMasks::DimmedMasks(std::unique_ptr<UndersideDimming> undersides, const ToneCurve& tone,
                         std::optional<Mask> uniformity)
    : undersides_(std::move(undersides)),
      threshold_({.threshold = tone.threshold}, std::nullopt),
      projector_({.gamma = tone.gamma}, std::move(uniformity)) {}

const Mask& DimmedMasks::mask(std::size_t layer, const Mask& coverage) {
  if (light_.width() != coverage.width() || light_.height() != coverage.height())
    light_ = mask_ = Mask(coverage.width(), coverage.height());
  threshold_.apply(coverage, light_);
  dim(undersides_->dimmed(layer), light_);
  if (projector_.is_none()) return light_;
  projector_.apply(light_, mask_);
  return mask_;
}

}  // namespace contourd
