#include "daemon/printed_part.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>

#include "core/image/part_picture.hpp"
#include "core/image/thumbnail.hpp"
#include "daemon/layer_pictures.hpp"

namespace contourd {
namespace {

using Steady = MaskBudget::Clock;

// One mask takes no more of the time than this share: the others are wanted, too.
constexpr int kLongestShare = 8;

// Which of the exposed layers is at a height. Asked for rising heights.
class ExposedLayers {
 public:
  explicit ExposedLayers(std::span<const LayerRecord> layers) : layers_(layers), next_(layers.begin()) {}

  [[nodiscard]] Nanometers top() const {
    Nanometers top{};
    for (const LayerRecord& layer : layers_) {
      if (layer.complete) top = std::max(top, layer.bottom + layer.thickness);
    }
    return top;
  }

  // Null where nothing was exposed.
  const LayerRecord* at(Nanometers height) {
    while (next_ != layers_.end() && (!next_->complete || next_->bottom + next_->thickness <= height))
      ++next_;
    return next_ != layers_.end() && next_->bottom <= height ? &*next_ : nullptr;
  }

 private:
  std::span<const LayerRecord> layers_;
  std::span<const LayerRecord>::iterator next_;
};

// What masks cover, made as small as the picture shows it. The last one is kept.
class SmallMasks {
 public:
  SmallMasks(ContourEngine& engine, const PixelBox& box, Pixels longest, Steady::time_point deadline)
      : engine_(engine),
        box_(box),
        longest_(longest),
        deadline_(deadline),
        longest_mask_((deadline - Steady::now()) / kLongestShare),
        last_(make_thumbnail(engine.coverage(), box, longest)) {}

  [[nodiscard]] const Mask& last() const { return last_; }

  // The last one again when it is `late` or its own time is over.
  const Mask& at(Nanometers height, Steady::time_point late) {
    const Steady::time_point now = Steady::now();
    if (height_ == height || (height_ && now >= late)) return last_;
    height_ = height;
    MaskBudget budget(std::min(deadline_, now + longest_mask_));
    if (budget.look_at_the_clock() && engine_.mask_within(height, budget) != nullptr)
      last_ = make_thumbnail(engine_.coverage(), box_, longest_);
    return last_;
  }

 private:
  ContourEngine& engine_;
  PixelBox box_;
  Pixels longest_;
  Steady::time_point deadline_;
  Steady::duration longest_mask_;
  std::optional<Nanometers> height_;
  Mask last_;
};

}  // namespace

Mask draw_printed_part(const PrintReport& report, ContourEngine& engine, Steady::time_point deadline) {
  const Steady::time_point start = Steady::now();
  ExposedLayers layers(report.layers);
  const double printed_mm = to_millimeters(layers.top()).count();
  const double height_mm =
      std::max(printed_mm, report.outcome == PrintOutcome::Done ? 0 : report.summary.height_mm);
  if (!(height_mm > 0)) return {kPrintedPartSide, kPrintedPartSide};

  const PixelBox box = box_around(engine.models(), engine.coverage().width(), engine.coverage().height());
  const PixelMap& map = engine.models().front().copies.front();
  const PixelPoint origin = map.to_pixels({0, 0}), beside = map.to_pixels({1, 1});
  PartPicture::Box part{Pixels{box.right - box.left}, Pixels{box.bottom - box.top},
                        height_mm * map.pixels_per_mm(), beside.x<origin.x, beside.y> origin.y};
  const double scale = PartPicture::scale_of(part, kPrintedPartSide);
  const Pixels longer = std::max(part.columns, part.rows);
  const Pixels longest{std::clamp(static_cast<std::int32_t>(longer.count() * scale), 1, longer.count())};
  SmallMasks masks(engine, box, longest, deadline);
  part.height *= static_cast<double>(longest.count()) / longer.count();
  part.columns = masks.last().width();
  part.rows = masks.last().height();

  PartPicture picture(part, kPrintedPartSide);
  const Mask dark(part.columns, part.rows);
  bool faint = false;
  for (std::int32_t i = 0; i < picture.masks(); ++i) {
    const Nanometers height{std::llround(picture.next_height() * height_mm * 1e6)};
    const Steady::time_point late = start + (deadline - start) / picture.masks() * (i + 1);
    if (!faint && height >= layers.top()) {
      picture.add_faintly_from_here();
      faint = true;
    }
    const LayerRecord* const layer = layers.at(height);
    if (faint || layer != nullptr) {
      picture.add(masks.at(faint ? height : layer->mask_height, late));
    } else {
      picture.add(dark);
    }
  }
  return picture.draw();
}

}  // namespace contourd
