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
    for (const MaskIsland& island : finder_.find(bright_, beneath_, limits_).here) {
      const SupportContact contact = contact_of(island, bottom);
      if (!rests) {
        add(contact, island, thickness);
      } else if (islands_.resting.size() < kMostContacts) {
        islands_.resting.push_back(contact);
      }
    }
  }

  [[nodiscard]] PrintedIslands islands() {
    const std::vector<std::optional<Surface>> surfaces =
        surfaces_beneath(request_.models, request_.display, places_);
    for (std::size_t i = 0; i < islands_.missed.size(); ++i) {
      if (!surfaces[i]) continue;
      islands_.missed[i].place.z = surfaces[i]->z_mm;
      islands_.missed[i].outward = surfaces[i]->outward;
    }
    return std::move(islands_);
  }

 private:
  [[nodiscard]] double pixel_mm2() const { return pitch_mm_ * pitch_mm_; }

  [[nodiscard]] SupportContact contact_of(const MaskIsland& island, Nanometers bottom) const {
    const Point at = on_plate(request_.display, pixel_of(island, bright_));
    return {{at.x, at.y, to_millimeters(bottom).count()},
            {0, 0, -1},
            ContactCause::Island,
            static_cast<double>(island.pixels) * pixel_mm2()};
  }

  void add(const SupportContact& contact, const MaskIsland& island, Nanometers thickness) {
    const double thick_mm = to_millimeters(thickness).count();
    const PlatePoint& at = contact.place;
    const auto is_here = [&](const UnheldPlace& unheld) {
      const PlatePoint& place = unheld.contact.place;
      return std::fabs(place.z - at.z) <= kSamePlaceMm &&
             std::fabs(place.x - at.x) <= (island.right - island.left) * pitch_mm_ + kSamePlaceMm &&
             std::fabs(place.y - at.y) <= (island.bottom - island.top) * pitch_mm_ + kSamePlaceMm;
    };
    if (islands_.missed.size() == kMostContacts || std::ranges::any_of(supports_.unheld, is_here)) return;
    places_.push_back({{at.x, at.y},
                       at.z - 2.5 * thick_mm,
                       at.z + thick_mm / 2,
                       request_.settings.tip_diameter.count() / 2});
    islands_.missed.push_back(contact);
  }

  const SupportRequest& request_;
  const Supports& supports_;
  double pitch_mm_;
  ContourEngine engine_;
  IslandFinder finder_;
  IslandFinder::Limits limits_{};
  MaskRuns lit_, bright_, beneath_;
  std::vector<SurfacePlace> places_;
  PrintedIslands islands_;
};

}  // namespace

PrintedIslands missed_islands(const SupportRequest& request, const Supports& supports,
                              const std::stop_token& stop) {
  MissedIslands islands(request, supports);
  Nanometers bottom{};
  for (const Nanometers thickness : request.printed.thicknesses) {
    if (stop.stop_requested()) return {};
    islands.add_layer(bottom, thickness);
    bottom += thickness;
  }
  return islands.islands();
}

}  // namespace contourd
