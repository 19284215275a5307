#include "core/cure/dark_copies.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>

#include "core/contract/expects.hpp"
#include "core/support/support_mesh.hpp"

namespace contourd {
namespace {

// Returns the lowest height above all masks that show a copy.
Nanometers dark_from(const DarkCopy& dark, const CutLayers& layers) {
  if (dark.layer == 0) return Nanometers{std::numeric_limits<std::int64_t>::min()};
  return layers.height_of(dark.layer - 1) + Nanometers{1};
}

PrintedUpTo end_of(const DarkCopy& dark, const CutLayers& layers) {
  if (dark.layer == 0) return {0, -std::numeric_limits<double>::infinity()};
  return {in_mm(layers.layers[dark.layer - 1].top), in_mm(layers.height_of(dark.layer - 1))};
}

void add_support(std::span<const SupportPrimitive> primitives, const DisplayGeometry& display,
                 const PrintedUpTo& up_to, std::vector<ComparedModel>& compared) {
  std::vector<Facet> facets = support_mesh(primitives);
  if (facets.empty()) return;
  HeightIndex mesh(std::move(facets));
  const Nanometers lowest = to_nanometers(Millimeters{mesh.bounds().min_z}).value_or(Nanometers{});
  compared.push_back({{{std::make_shared<const HeightIndex>(std::move(mesh)), Elevation(lowest)},
                       {PixelMap::true_scale(display, {0, 0})}},
                      up_to});
}

// Returns the primitives that are not among those left, which have the same order.
std::vector<SupportPrimitive> without(std::span<const SupportPrimitive> left,
                                      std::span<const SupportPrimitive> primitives) {
  std::vector<SupportPrimitive> gone;
  auto next = left.begin();
  for (const SupportPrimitive& each : primitives) {
    if (next != left.end() && each == *next) {
      ++next;
    } else {
      gone.push_back(each);
    }
  }
  return gone;
}

}  // namespace

Nanometers CutLayers::height_of(std::size_t layer) const {
  expects(layer < layers.size() && (mask_heights.empty() || mask_heights.size() == layers.size()),
          "there is such a layer, and each has a height or none");
  if (!mask_heights.empty()) return mask_heights[layer];
  const LayerDose& of = layers[layer];
  return of.top - of.thickness + of.thickness / 2;
}

void leave_dark(std::span<const DarkCopy> dark, const CutLayers& layers, ContourEngine& engine,
                UndersideDimming* undersides) {
  expects(std::ranges::is_sorted(dark, {}, &DarkCopy::layer) &&
              (dark.empty() || dark.back().layer <= layers.layers.size()),
          "layers from which on copies are dark are layers of the print, and do not fall");
  engine.light_all();
  if (undersides != nullptr) undersides->include_all();
  Nanometers from{std::numeric_limits<std::int64_t>::min()};
  for (const DarkCopy& each : dark) {
    from = std::max(from, dark_from(each, layers));  // measured heights may fall
    engine.darken(each.model, each.copy, from);
    if (each.supports_left) engine.replace_beside(each.supports_left, from);
    if (undersides != nullptr && each.layer < layers.layers.size())
      undersides->exclude(each.model, each.copy, each.supports_left, each.layer);
  }
}

std::vector<ComparedModel> compared_models(std::span<const PlateModel> models, std::span<const DarkCopy> dark,
                                           const CutLayers& layers) {
  std::vector<ComparedModel> compared;
  for (std::size_t i = 0; i < models.size(); ++i) {
    ComparedModel whole{models[i]};
    whole.model.copies.clear();
    for (std::size_t copy = 0; copy < models[i].copies.size(); ++copy) {
      const auto found = std::ranges::find_if(
          dark, [&](const DarkCopy& each) { return each.model == i && each.copy == copy; });
      if (found == dark.end()) {
        whole.model.copies.push_back(models[i].copies[copy]);
        continue;
      }
      ComparedModel& cut = compared.emplace_back(ComparedModel{models[i], end_of(*found, layers)});
      cut.model.copies = {models[i].copies[copy]};
    }
    if (!whole.model.copies.empty()) compared.push_back(std::move(whole));
  }
  return compared;
}

std::vector<ComparedModel> compared_supports(const SupportStructure& supports, const DisplayGeometry& display,
                                             std::span<const DarkCopy> dark, const CutLayers& layers) {
  std::vector<ComparedModel> compared;
  std::span<const SupportPrimitive> standing = supports.primitives();
  for (const DarkCopy& each : dark) {
    if (!each.supports_left) continue;
    const std::span<const SupportPrimitive> left = each.supports_left->primitives();
    add_support(without(left, standing), display, end_of(each, layers), compared);
    standing = left;
  }
  add_support(standing, display, {}, compared);
  return compared;
}

std::vector<CutCopy> cut_copies(std::span<const PlateModel> models, std::span<const DarkCopy> dark,
                                const CutLayers& layers) {
  std::vector<CutCopy> cut;
  for (const DarkCopy& each : dark) {
    std::size_t number = each.copy;
    for (const PlateModel& model : models.first(each.model))
      number += model.copies.size();
    cut.push_back({number, end_of(each, layers).top_mm});
  }
  return cut;
}

}  // namespace contourd
