#include "daemon/formats/threemf_facets.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <vector>

#include "daemon/json/config_error.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

// Components within components.
constexpr unsigned kMostDepth = 32;
// Objects, counted as often as they are placed. An object without a mesh takes time, too.
constexpr std::uint64_t kMostPlaced = 1'000'000;
constexpr std::uint64_t kCountLimit = std::uint64_t{1} << 40U;

// How much an object becomes with all its components.
struct Extent {
  std::uint64_t facets = 0, placed = 1;
  unsigned depth = 1;

  void add(const Extent& component) {
    facets = std::min(facets + component.facets, kCountLimit);
    placed = std::min(placed + component.placed, kCountLimit);
    depth = std::max(depth, component.depth + 1);
  }
};

// Objects that are not filled, by the specification (3.4.2): a support surface, an open surface, and what is
// not built.
bool is_filled(const ThreeMfObject& object) {
  return object.type == "model" || object.type == "solidsupport";
}

class Expansion {
 public:
  Expansion(const ThreeMfModel& model, std::uint64_t most_facets)
      : model_(model), root_(model.parts.at(model.root)), most_facets_(most_facets) {}

  Model run() {
    // The root comes last: its objects may be made of those of the other parts.
    for (const auto& [name, part] : model_.parts)
      if (&part != &root_) measure(part);
    measure(root_);
    Extent all;
    for (const ThreeMfReference& item : root_.items)
      all.add(extent_of(root_, item));
    refuse(all);
    made_.facets.reserve(all.facets);
    ThreeMfTransform to_mm;
    to_mm.m[0] = to_mm.m[4] = to_mm.m[8] = millimeters_in(root_.unit);
    for (const ThreeMfReference& item : root_.items)
      place(root_, item, to_mm);
    return std::move(made_);
  }

  // Objects of the build that are not filled. Valid after run().
  [[nodiscard]] std::size_t left_out() const { return left_out_.size(); }

 private:
  struct Place {
    const ThreeMfPart& part;
    const ThreeMfObject& object;
  };

  [[nodiscard]] Place find(const ThreeMfPart& from, const ThreeMfReference& reference) const {
    const auto other = reference.path.empty() ? model_.parts.end() : model_.parts.find(reference.path);
    const ThreeMfPart& part = other == model_.parts.end() ? from : other->second;
    const auto number = part.numbers.find(reference.object);
    if (number == part.numbers.end())
      throw ModelError(
          fmt::format("the 3MF model names object {}{}, which does not exist: export the model again",
                      reference.object, reference.path.empty() ? "" : " of " + in_quotes(reference.path)));
    return {part, part.objects[number->second]};
  }

  [[nodiscard]] const Extent& extent_of(const ThreeMfPart& from, const ThreeMfReference& reference) const {
    const ThreeMfObject& object = find(from, reference).object;
    const auto extent = extents_.find(&object);
    if (extent == extents_.end())
      throw ModelError(
          fmt::format("object {} of the 3MF model is a component of an object that does not come "
                      "after it: export the model again",
                      object.id));
    return extent->second;
  }

  void measure(const ThreeMfPart& part) {
    if (part.unit != root_.unit)
      throw ModelError("the files of the 3MF model have different units: export the model again");
    for (const ThreeMfObject& object : part.objects) {
      Extent extent;
      if (is_filled(object)) {
        extent.facets = object.triangles.size();
        for (const ThreeMfReference& component : object.components)
          extent.add(extent_of(part, component));
      }
      if (extent.depth > kMostDepth)
        throw ModelError(
            fmt::format("the 3MF model has components nested more than {} levels deep: export it as "
                        "one mesh",
                        kMostDepth));
      extents_.emplace(&object, extent);
    }
  }

  void refuse(const Extent& all) const {
    if (all.facets > most_facets_)
      throw ModelError(
          fmt::format("the 3MF model's components and copies come to {}{} facets, and there is room "
                      "for {}: print fewer copies, or simplify the model",
                      all.facets == kCountLimit ? "more than " : "", all.facets, most_facets_));
    if (all.placed > kMostPlaced)
      throw ModelError(
          fmt::format("the 3MF model places more than {} objects: export it as one mesh", kMostPlaced));
  }

  void place(const ThreeMfPart& from, const ThreeMfReference& reference, const ThreeMfTransform& outer) {
    const auto& [part, object] = find(from, reference);
    if (!is_filled(object)) {
      left_out_.insert(&object);
      return;
    }
    if (!object.has_geometry)
      throw ModelError(
          fmt::format("object {} of the 3MF model has neither triangles nor components: export the model "
                      "as a mesh, or as STL",
                      object.id));
    const ThreeMfTransform transform = combined(reference.transform, outer);
    if (transform.determinant() == 0)
      throw ModelError(fmt::format(
          "the transform of object {} of the 3MF model makes it flat: export the model again", object.id));
    add_mesh(object, transform);
    for (const ThreeMfReference& component : object.components)
      place(part, component, transform);
  }

  void add_mesh(const ThreeMfObject& object, const ThreeMfTransform& transform) {
    if (object.triangles.empty()) return;
    const bool is_identity = transform == ThreeMfTransform{}, mirrors = transform.determinant() < 0;
    const auto at = [&](std::uint32_t number) {
      const Vertex& vertex = object.vertices[number];
      return is_identity ? vertex : transform(vertex);
    };
    for (const auto& [v1, v2, v3] : object.triangles) {
      made_.facets.push_back({{at(v1), at(mirrors ? v3 : v2), at(mirrors ? v2 : v3)}});
      if (!is_identity && !is_finite(made_.facets.back()))
        throw ModelError(fmt::format(
            "object {} of the 3MF model leaves the range of numbers by its transform", object.id));
    }
  }

  const ThreeMfModel& model_;
  const ThreeMfPart& root_;
  std::uint64_t most_facets_;
  std::map<const ThreeMfObject*, Extent> extents_;
  std::set<const ThreeMfObject*> left_out_;
  Model made_;
};

// Removes the triangles of the volumes from the object.
void remove_volumes(ThreeMfObject& object, const std::vector<ThreeMfVolume>& volumes) {
  std::vector<bool> is_removed(object.triangles.size());
  for (const ThreeMfVolume& volume : volumes) {
    const std::size_t end = std::min<std::size_t>(std::size_t{volume.last} + 1, is_removed.size());
    for (std::size_t i = volume.first; i < end; ++i)
      is_removed[i] = true;
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < is_removed.size(); ++i)
    if (!is_removed[i]) object.triangles[kept++] = object.triangles[i];
  object.triangles.resize(kept);
}

}  // namespace

std::map<std::string, std::size_t> leave_out(ThreeMfModel& model, const ThreeMfSideFile& side_file) {
  std::map<std::string, std::size_t> kinds;
  for (ThreeMfObject& object : model.parts.at(model.root).objects) {
    const auto volumes = side_file.volumes.find(object.id);
    if (volumes != side_file.volumes.end() && !object.triangles.empty()) {
      for (const ThreeMfVolume& volume : volumes->second) {
        if (volume.last >= object.triangles.size())
          throw ModelError(
              fmt::format("a {} of the 3MF model is triangles {} to {} of object {}, which has only {}: "
                          "export the model again",
                          volume.kind, volume.first, volume.last, object.id, object.triangles.size()));
        ++kinds[volume.kind];
      }
      remove_volumes(object, volumes->second);
    }
    std::erase_if(object.components, [&](const ThreeMfReference& component) {
      const auto found = side_file.components.find({object.id, component.object});
      if (found == side_file.components.end()) return false;
      ++kinds[found->second];
      return true;
    });
  }
  return kinds;
}

std::map<std::string, std::size_t> leave_out_kinds(ThreeMfModel& model) {
  std::map<std::string, std::size_t> kinds;
  for (auto& named : model.parts) {
    ThreeMfPart& part = named.second;
    const auto is_left_out = [&](const ThreeMfReference& reference) {
      const auto other = reference.path.empty() ? model.parts.end() : model.parts.find(reference.path);
      const ThreeMfPart& from = other == model.parts.end() ? part : other->second;
      const auto number = from.numbers.find(reference.object);
      if (number == from.numbers.end()) return false;
      const std::string& kind = from.objects[number->second].kind;
      if (!kind.empty()) ++kinds[kind];
      return !kind.empty();
    };
    std::erase_if(part.items, is_left_out);
    for (ThreeMfObject& object : part.objects)
      std::erase_if(object.components, is_left_out);
  }
  return kinds;
}

Model facets_of(const ThreeMfModel& model, std::uint64_t most_facets) {
  const ThreeMfPart& root = model.parts.at(model.root);
  if (root.items.empty())
    throw ModelError(root.not_printable > 0
                         ? "the 3MF model has nothing to print: every object is marked as not printable"
                         : "the 3MF model has nothing to print: its build has no item");
  Expansion expansion(model, most_facets);
  Model made = expansion.run();
  made.unit = root.unit;
  if (root.not_printable > 0)
    made.warnings.push_back(fmt::format("the file marks {} as not printable: left out",
                                        count_of(root.not_printable, "object", "objects")));
  if (expansion.left_out() > 0)
    made.warnings.push_back(fmt::format("{} of the types support, surface and other left out",
                                        count_of(expansion.left_out(), "object is", "objects are")));
  return made;
}

}  // namespace contourd
