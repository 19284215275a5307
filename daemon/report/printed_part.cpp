#include "daemon/report/printed_part.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/image/part_picture.hpp"
#include "core/image/thumbnail.hpp"
#include "daemon/report/layer_pictures.hpp"
#include "hw/png_file.hpp"

namespace contourd {
namespace {

using Steady = MaskBudget::Clock;

// Finds the exposed layer at a height. Heights have to be queried in rising order.
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

  // Returns the layer at this height; null if no layer was exposed there.
  const LayerRecord* at(Nanometers height) {
    while (next_ != layers_.end() && (!next_->complete || next_->bottom + next_->thickness <= height))
      ++next_;
    return next_ != layers_.end() && next_->bottom <= height ? &*next_ : nullptr;
  }

 private:
  std::span<const LayerRecord> layers_;
  std::span<const LayerRecord>::iterator next_;
};

// Computes masks and scales them down to the size of the picture. Keeps the last one.
class SmallMasks {
 public:
  SmallMasks(ContourEngine& engine, const PixelBox& box, Pixels longest, Steady::time_point deadline)
      : engine_(engine), box_(box), longest_(longest), deadline_(deadline) {}

  // Returns the mask at a height; null after the deadline. A mask with too many sides counts as dark, as it
  // did in the print.
  const Mask* at(Nanometers height) {
    if (height_ == height) return &last_;
    const Steady::time_point now = Steady::now();
    if (now >= deadline_) return nullptr;
    height_ = height;
    MaskBudget budget(deadline_);
    const bool made = engine_.mask_within(height, budget) != nullptr;
    if (!made && !budget.too_many_sides()) return nullptr;
    last_ = make_thumbnail(engine_.coverage(), box_, longest_);
    if (!made) last_ = Mask(last_.width(), last_.height());
    took_ += Steady::now() - now;
    return &last_;
  }

  [[nodiscard]] Steady::duration took() const { return took_; }

 private:
  ContourEngine& engine_;
  PixelBox box_;
  Pixels longest_;
  Steady::time_point deadline_;
  std::optional<Nanometers> height_;
  Mask last_;
  Steady::duration took_{};
};

class PrintedPart {
 public:
  PrintedPart(const PrintReport& report, ContourEngine& engine)
      : report_(report),
        engine_(engine),
        box_(box_around(engine.models(), engine.coverage().width(), engine.coverage().height(),
                        supports_of(report.summary))) {
    if (!supports_of(report.summary).empty()) {
      supports_.emplace(std::vector<PlateModel>{}, EngineSettings{.display = display_of(engine)},
                        report.summary.supports->structure);
    }
    const Nanometers printed = ExposedLayers(report.layers).top();
    const bool all = report.outcome == PrintOutcome::Done;
    height_mm_ = std::max(to_millimeters(printed).count(), all ? 0 : report.summary.height_mm);
  }

  [[nodiscard]] bool has_height() const { return height_mm_ > 0; }

  struct Drawing {
    PartPicture::Drawing part;         // with a mark for each contact of the supports
    Steady::duration masks{}, took{};  // time to compute the masks, and time in all
  };
  // Draws the part with this side; returns nullopt if the deadline passes before.
  [[nodiscard]] std::optional<Drawing> draw(Pixels side, Steady::time_point deadline) {
    const Steady::time_point start = Steady::now();
    PartPicture::Box part = box_in_pixels();
    const Pixels longer = std::max(part.columns, part.rows);
    const double scale = PartPicture::scale_of(part, side);
    const Pixels longest{std::clamp(static_cast<std::int32_t>(longer.count() * scale), 1, longer.count())};
    const Mask dark =
        make_thumbnail(Mask(engine_.coverage().width(), engine_.coverage().height()), box_, longest);
    part.height *= static_cast<double>(longest.count()) / longer.count();
    part.columns = dark.width();
    part.rows = dark.height();

    PartPicture picture(part, side);
    SmallMasks masks(engine_, box_, longest, deadline);
    std::optional<SmallMasks> supports;
    if (supports_) supports.emplace(*supports_, box_, longest, deadline);
    ExposedLayers layers(report_.layers);
    const Nanometers top = layers.top();
    bool faint = false;
    for (std::int32_t i = 0; i < picture.masks(); ++i) {
      const Nanometers height{std::llround(picture.next_height() * height_mm_ * 1e6)};
      if (!faint && height >= top) {
        picture.add_faintly_from_here();
        faint = true;
      }
      const LayerRecord* const layer = layers.at(height);
      const bool is_dark = !faint && layer == nullptr;
      const Nanometers cut = faint || is_dark ? height : layer->mask_height;
      const Mask* const mask = is_dark ? &dark : masks.at(cut);
      const Mask* const beside = !supports ? nullptr : is_dark ? &dark : supports->at(cut);
      if (mask == nullptr || (supports && beside == nullptr)) return std::nullopt;
      picture.add(*mask, beside);
    }
    PartPicture::Drawing drawn = picture.draw(contacts());
    return Drawing{std::move(drawn), masks.took(), Steady::now() - start};
  }

 private:
  [[nodiscard]] PartPicture::Box box_in_pixels() const {
    const PixelMap& map = engine_.models().front().copies.front();
    const PixelPoint origin = map.to_pixels({0, 0}), beside = map.to_pixels({1, 1});
    return {Pixels{box_.right - box_.left}, Pixels{box_.bottom - box_.top}, height_mm_ * map.pixels_per_mm(),
            beside.x<origin.x, beside.y> origin.y};
  }

  [[nodiscard]] std::vector<PartPicture::Place> contacts() const {
    std::vector<PartPicture::Place> places;
    if (!report_.summary.supports) return places;
    const PixelMap map = PixelMap::true_scale(display_of(engine_), {0, 0});
    for (const SupportContact& contact : report_.summary.supports->contacts) {
      const PixelPoint at = map.to_pixels({contact.place.x, contact.place.y});
      places.push_back({(at.x - box_.left) / (box_.right - box_.left),
                        (at.y - box_.top) / (box_.bottom - box_.top), contact.place.z / height_mm_});
    }
    return places;
  }

  const PrintReport& report_;
  ContourEngine& engine_;
  std::optional<ContourEngine> supports_;  // makes masks of the supports alone; nullopt without supports
  PixelBox box_;
  double height_mm_ = 0;
};

// Estimates the time for a drawing `factor` times as wide and high: it takes `factor` times as many masks,
// each of which is looked up for factor^2 times as many pixels.
Steady::duration enlarged(const PrintedPart::Drawing& drawing, double factor) {
  const auto rest = drawing.took - drawing.masks;
  return std::chrono::duration_cast<Steady::duration>(drawing.masks * factor +
                                                      rest * factor * factor * factor);
}

// Encodes the picture as PNG. Odd values are pixels of supports and get their own colour.
std::vector<std::uint8_t> encode(const PrintReport& report, const Mask& part) {
  if (supports_of(report.summary).empty()) return encode_png(part);
  Palette palette;
  for (std::size_t grey = 0; grey < palette.size(); ++grey) {
    const auto value = static_cast<std::uint8_t>(grey);
    const auto part_of = [value](double share) { return static_cast<std::uint8_t>(share * value); };
    palette[grey] = grey % 2 == 0 ? Rgb{value, value, value} : Rgb{part_of(0.72), part_of(0.6), value};
  }
  return encode_png(part, &palette);
}

PartPreview preview_of(const PrintReport& report, const PartPicture::Drawing& part) {
  PartPreview preview{part.picture.width(), encode(report, part.picture), {}};
  for (std::size_t i = 0; i < part.marks.size(); ++i)
    preview.contacts.push_back({part.marks[i], report.summary.supports->contacts[i].cause});
  return preview;
}

}  // namespace

std::optional<PartPreview> draw_printed_part(const PrintReport& report, ContourEngine& engine,
                                             Steady::time_point deadline) {
  PrintedPart part(report, engine);
  if (!part.has_height()) return preview_of(report, {Mask(kPrintedPartSide, kPrintedPartSide), {}});
  constexpr int kSmallest = 4;  // first draws at a quarter of the side, to measure the time
  std::optional<PrintedPart::Drawing> drawing = part.draw(kPrintedPartSide / kSmallest, deadline);
  if (!drawing) return std::nullopt;
  for (const double factor : {4.0, 3.0, 2.0}) {
    if (Steady::now() + enlarged(*drawing, factor) > deadline) continue;
    const auto side = static_cast<std::int32_t>(kPrintedPartSide.count() * factor / kSmallest);
    if (const auto larger = part.draw(Pixels{side}, deadline)) return preview_of(report, larger->part);
    break;
  }
  return preview_of(report, drawing->part);
}

}  // namespace contourd
