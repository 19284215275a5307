#include "core/routing/missed_islands.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include "core/analysis/island_finder.hpp"
#include "core/mask/mask_runs.hpp"
#include "core/overhangs/surfaces_beneath.hpp"

namespace contourd {
namespace {

// A part that lies on less of the layer beneath is not carried, unless the part is small.
constexpr double kContactMm2 = 0.01;
// An island of at most this area that is gone in the next layer is too faint to cure.
constexpr double kSpeckMm2 = 0.0125;
// An unheld place so near is the island's own.
constexpr double kSamePlaceMm = 0.5;

// Returns the middle of the island's pixel nearest to its centre.
PixelPoint pixel_of(const MaskIsland& island, const MaskRuns& layer) {
  PixelPoint nearest = island.center;
  double least = HUGE_VAL;
  for (std::int32_t row = island.top; row < island.bottom; ++row) {
    for (const PixelRun& run : layer.in_row(row)) {
      if (run.end <= island.left || run.first >= island.right) continue;
      const PixelPoint at{std::clamp(std::floor(island.center.x), run.first + 0.0, run.end - 1.0) + 0.5,
                          row + 0.5};
      const double distance = std::hypot(at.x - island.center.x, at.y - island.center.y);
      if (distance < least) nearest = at;
      least = std::min(least, distance);
    }
  }
  return nearest;
}

class MissedIslands {
 public:
  MissedIslands(const SupportRequest& request, const Supports& supports)
      : request_(request),
        supports_(supports),
        pitch_mm_(to_millimeters(request.display.pixel_pitch).count()),
        engine_(request.models,
                {.display = request.display,
                 .anti_aliasing = request.printed.anti_aliasing,
                 .compensation = request.printed.compensation},
                supports.structure) {
    limits_.contact_pixels = static_cast<std::int64_t>(std::ceil(kContactMm2 / pixel_mm2()));
    limits_.speck_grey = static_cast<std::uint64_t>(255 * std::max(kSpeckMm2 / pixel_mm2(), 1.0) + 1e-3);
  }

  void add_layer(Nanometers bottom, Nanometers thickness) {
    std::swap(bright_, beneath_);
    const Mask& mask = engine_.mask_at(bottom + thickness / 2);
    lit_.extract(mask);
    bright_.extract_bright(mask, lit_, request_.printed.least_grey);
    if (beneath_.rows() <= 0) return;
    const bool rests = to_millimeters(bottom) <= request_.settings.closed_gap + Millimeters{1e-6};
    for (const MaskIsland& island : finder_.find(bright_, beneath_, limits_).here)
      if (!rests) add(island, bottom, thickness);
  }

  [[nodiscard]] std::vector<SupportContact> contacts() {
    const std::vector<std::optional<Surface>> surfaces =
        surfaces_beneath(request_.models, request_.display, places_);
    for (std::size_t i = 0; i < contacts_.size(); ++i) {
      if (!surfaces[i]) continue;
      contacts_[i].place.z = surfaces[i]->z_mm;
      contacts_[i].outward = surfaces[i]->outward;
    }
    return std::move(contacts_);
  }

 private:
  [[nodiscard]] double pixel_mm2() const { return pitch_mm_ * pitch_mm_; }

  void add(const MaskIsland& island, Nanometers bottom, Nanometers thickness) {
    const double bottom_mm = to_millimeters(bottom).count(), thick_mm = to_millimeters(thickness).count();
    const Point at = on_plate(request_.display, pixel_of(island, bright_));
    const auto is_here = [&](const UnheldPlace& unheld) {
      const PlatePoint& place = unheld.contact.place;
      return std::fabs(place.z - bottom_mm) <= kSamePlaceMm &&
             std::fabs(place.x - at.x) <= (island.right - island.left) * pitch_mm_ + kSamePlaceMm &&
             std::fabs(place.y - at.y) <= (island.bottom - island.top) * pitch_mm_ + kSamePlaceMm;
    };
    if (contacts_.size() == kMostContacts || std::ranges::any_of(supports_.unheld, is_here)) return;
    places_.push_back({at, bottom_mm - 2.5 * thick_mm, bottom_mm + thick_mm / 2,
                       request_.settings.tip_diameter.count() / 2});
    contacts_.push_back({{at.x, at.y, bottom_mm},
                         {0, 0, -1},
                         ContactCause::Island,
                         static_cast<double>(island.pixels) * pixel_mm2()});
  }

  const SupportRequest& request_;
  const Supports& supports_;
  double pitch_mm_;
  ContourEngine engine_;
  IslandFinder finder_;
  IslandFinder::Limits limits_{};
  MaskRuns lit_, bright_, beneath_;
  std::vector<SurfacePlace> places_;
  std::vector<SupportContact> contacts_;
};

}  // namespace

std::vector<SupportContact> missed_islands(const SupportRequest& request, const Supports& supports,
                                           const std::stop_token& stop) {
  MissedIslands islands(request, supports);
  Nanometers bottom{};
  for (const Nanometers thickness : request.printed.thicknesses) {
    if (stop.stop_requested()) return {};
    islands.add_layer(bottom, thickness);
    bottom += thickness;
  }
  return islands.contacts();
}

}  // namespace contourd
