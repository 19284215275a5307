// Prints a digest of everything that the core computes for a broad set of models, heights and settings, one
// per line. Two machines compute the same masks exactly if they print the same bytes (.ci/arm64 compares
// two). Prints one part with the part's number as the argument, and the number of parts with "--parts".
#include <algorithm>
#include <bit>
#include <chrono>
#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/cure/underside_dimming.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/formats/model_reader.hpp"
#include "core/layers/print_layers.hpp"
#include "core/model/mesh_report.hpp"
#include "core/model/placement.hpp"
#include "core/model/sine_cosine.hpp"
#include "core/orientation/orientation_choice.hpp"
#include "core/support/support_mesh.hpp"
#include "core/support/support_structure.hpp"
#include "tests/models/damage.hpp"

namespace contourd {
namespace {

// FNV-1a, 64 bits.
class Digest {
 public:
  void add(std::uint8_t byte) { state_ = (state_ ^ byte) * 0x100000001B3U; }
  void add(std::uint64_t word) {
    for (int shift = 0; shift < 64; shift += 8)
      add(static_cast<std::uint8_t>(word >> shift));
  }
  void add(double number) { add(std::bit_cast<std::uint64_t>(number)); }
  [[nodiscard]] std::uint64_t value() const { return state_; }

 private:
  std::uint64_t state_ = 0xCBF29CE484222325U;
};

std::uint64_t digest_of(const Mask& mask) {
  Digest digest;
  for (const std::uint8_t grey : mask.pixels())
    digest.add(grey);
  return digest.value();
}

std::uint64_t digest_of(const Contours& contours) {
  Digest digest;
  for (const Point& p : contours.points) {
    digest.add(p.x);
    digest.add(p.y);
  }
  for (const ContourLoop& loop : contours.loops)
    digest.add(std::uint64_t{loop.point_count});
  digest.add(contours.cracks.widest_gap.count());
  return digest.value();
}

struct Subject {
  std::string name;
  models::Facets facets;
};

std::vector<Subject> good_models() {
  models::Facets hollow = models::box({-8, -8, 0}, {8, 8, 12});
  models::Facets cavity = models::box({-5, -5, 3}, {5.3F, 5.7F, 9});
  models::invert(cavity);
  return {{"box", models::box({0.1F, 0.2F, 0.3F}, {12.7F, 9.9F, 7.1F})},
          {"sliver", models::box({-9, 0.013F, 0}, {9, 0.021F, 15})},
          {"hollow", models::together(hollow, cavity)},
          {"overlap", models::together(hollow, models::box({-3.3F, -3.3F, 5.5F}, {10.1F, 2.2F, 14.9F}))},
          {"sphere", models::sphere(7, 14)},
          {"gyroid", models::gyroid_sphere(8, 5, 24)}};
}

std::vector<Subject> bad_models() {
  models::Dice dice(2019);
  models::Facets shaken = models::gyroid_sphere(8, 5, 20);
  models::shake_corners(shaken, 0.02, dice);
  models::Facets holed = models::sphere(7, 14);
  models::drop_facets(holed, 0.02, dice);
  models::Facets split = models::gyroid_sphere(8, 5, 18);
  models::split_sides(split, 0.1, 0.02, dice);
  models::Facets turned = models::sphere(6, 10);
  std::swap(turned[7].vertices[0], turned[7].vertices[1]);
  return {{"shaken", shaken},
          {"holed", holed},
          {"split", split},
          {"turned", turned},
          {"soup", models::soup(300, 9, dice)},
          {"huge", models::soup(60, 3e38, dice)},
          {"tiny", models::soup(60, 1e-41, dice)}};
}

struct Setting {
  const char* name;
  AntiAliasing anti_aliasing;
  DisplayGeometry display;
  bool fit = false;
  bool copies = false;
  bool corrected = false;  // outline grown, less at the foot, and greys changed
};

std::vector<Setting> settings() {
  constexpr Pixels kWidth{321}, kHeight{217};
  const DisplayGeometry straight{kWidth, kHeight, Micrometers{101.0}};
  const DisplayGeometry mirrored{kWidth, kHeight, Micrometers{50.0}, true, true};
  return {{"grey", AntiAliasing::On, straight},
          {"1-bit", AntiAliasing::Off, straight},
          {"grey mirrored copies", AntiAliasing::On, mirrored, false, true},
          {"grey fit", AntiAliasing::On, straight, true},
          {"1-bit mirrored fit", AntiAliasing::Off, mirrored, true},
          {"grey corrected", AntiAliasing::On, straight, false, false, true}};
}

// Returns a uniformity mask with three quarters of the light at one edge and all of it at the other.
Mask uniformity_of(const DisplayGeometry& display) {
  Mask uniformity(display.width, display.height);
  const std::int32_t height = display.height.count();
  for (std::int32_t y = 0; y < height; ++y)
    std::ranges::fill(uniformity.row(y), static_cast<std::uint8_t>(191 + y * 64 / height));
  return uniformity;
}

EngineSettings engine_settings(const Setting& setting) {
  EngineSettings settings{setting.display, setting.anti_aliasing};
  if (setting.corrected) {
    settings.compensation = {Micrometers{37}, Micrometers{160}, Nanometers{3'000'000}};
    settings.tone = {2.2, 10};
    settings.uniformity = uniformity_of(setting.display);
  }
  return settings;
}

std::vector<PixelMap> maps_of(const Setting& setting, const Bounds& bounds) {
  if (setting.fit) return {PixelMap::fit(setting.display, bounds)};
  const Point center = bounds.center();
  std::vector<PixelMap> maps{PixelMap::true_scale(setting.display, center)};
  if (setting.copies) {
    maps.push_back(PixelMap::true_scale(setting.display, {center.x + 4.567, center.y - 1.234}));
    maps.push_back(PixelMap::true_scale(setting.display, {center.x - 40, center.y + 3.21}));
  }
  return maps;
}

void print_layers(const std::string& name, const HeightIndex& model, const Setting& setting) {
  const Bounds& bounds = model.bounds();
  ContourEngine engine(model, engine_settings(setting), maps_of(setting, bounds));
  // The bottom and the middle, where flat faces and vertices are, and heights in between.
  for (const double part : {0.0, 0.07, 0.213, 0.41, 0.5, 0.6401, 0.83, 0.97}) {
    const double z = bounds.min_z + part * bounds.size_z();
    std::printf("%s, %s, %.2f: %016" PRIx64 "\n", name.c_str(), setting.name, part,
                digest_of(engine.mask_at_z(Millimeters{z})));
  }
}

void print_contours(const std::string& name, const HeightIndex& model) {
  Section section;
  ContourLinker linker;
  Contours contours;
  for (const double part : {0.0, 0.1, 0.37, 0.5, 0.77}) {
    slice_at(model, Millimeters{model.bounds().min_z + part * model.bounds().size_z()}, section);
    linker.link(section.segments, Millimeters{0.05}, contours);
    std::printf("%s, contours, %.2f: %016" PRIx64 ", %zu loops, %u gaps, %u open\n", name.c_str(), part,
                digest_of(contours), contours.loops.size(), contours.cracks.gaps_closed,
                contours.cracks.open_chains);
  }
}

void print_adaptive_layers(const std::string& name, const models::Facets& facets) {
  const StandingModel model{std::make_shared<const HeightIndex>(facets)};
  const PrintLayers layers({model}, {Nanometers{20'000}, Nanometers{200'000}, Nanometers{12'000}});
  Digest digest;
  const std::vector<Nanometers> all = layers.all();
  for (const Nanometers thickness : all)
    digest.add(static_cast<std::uint64_t>(thickness.count()));
  std::printf("%s, %zu adaptive layers: %016" PRIx64 "\n", name.c_str(), all.size(), digest.value());
}

void print_orientation(const std::string& name, const models::Facets& facets) {
  const OrientationRequest request{.supports = {.lift = Millimeters{5}}, .keep_clean = {Direction{1, 0, 0}}};
  const OrientationChoice choice = choose_orientation(facets, request).value();
  Digest digest;
  for (const OrientationFigures& each : choice.ranked)
    for (const double figure : {each.up.x, each.up.y, each.up.z, each.score, each.contacts, each.support_mm3,
                                each.largest_mm2, each.standing_mm2, each.touched_mm2, each.size_x_mm})
      digest.add(figure);
  std::printf("%s, %u ways up: %016" PRIx64 "\n", name.c_str(), choice.tried, digest.value());
}

// Returns a model written to a file's bytes and read back, since the reader must agree too.
models::Facets read_back(const models::Facets& facets, bool ascii) {
  if (!ascii) return read_model(models::to_binary_stl(facets)).facets;
  const std::string text = models::to_ascii_stl(facets);
  return read_model(std::as_bytes(std::span(text))).facets;
}

void print_subject(const Subject& subject, const Orientation& orientation, const char* turn, bool ascii) {
  models::Facets facets = read_back(subject.facets, ascii);
  orient(facets, orientation);
  const std::string name = subject.name + " " + turn;
  Digest digest;
  for (const Facet& facet : facets) {
    for (const Vertex& v : facet.vertices) {
      for (const float coordinate : {v.x, v.y, v.z})
        digest.add(std::uint64_t{std::bit_cast<std::uint32_t>(coordinate)});
    }
  }
  digest.add(inspect_mesh(facets).volume_mm3);
  std::printf("%s, facets: %016" PRIx64 "\n", name.c_str(), digest.value());
  if (subject.name != "huge") print_adaptive_layers(name, facets);
  if (subject.name != "huge" && !facets.empty()) print_orientation(name, facets);
  const HeightIndex model(std::move(facets));
  for (const Setting& setting : settings())
    print_layers(name, model, setting);
  print_contours(name, model);
}

// Pillars, branches, horizontal braces, tips and balls around a model above the plate.
std::vector<SupportPrimitive> supports() {
  std::vector<SupportPrimitive> primitives;
  for (int i = 0; i < 40; ++i) {
    const auto [sine, cosine] = sine_cosine(i * 37.3);
    const double x = 0.31 * i * cosine, y = 0.23 * i * sine, top = 2 + 0.21 * i;
    primitives.push_back(Frustum{{x, y, 0}, {x, y, 1}, 1.9, 0.5});
    primitives.push_back(Frustum{{x, y, 1}, {x, y, top}, 0.61, 0.5});
    primitives.push_back(Ball{{x, y, top}, 0.503});
    primitives.push_back(
        Frustum{{x, y, top}, {x - 0.7 * cosine, y + 1.1 * sine, top + 1.3}, 0.5, 0.2 * (i % 2)});
    primitives.push_back(Frustum{{x, y, top}, {x + 2 * sine, y + 1.5, top + 0.01 * (i % 3)}, 0.3, 0.35});
  }
  return primitives;
}

void print_supports() {
  const auto structure = std::make_shared<const SupportStructure>(supports());
  const auto model = std::make_shared<const HeightIndex>(models::gyroid_sphere(8, 5, 24));
  for (const Setting& setting : settings()) {
    std::vector<PlateModel> standing(1);
    standing.front().model = model;
    standing.front().elevation = Elevation(Nanometers{5'000'000});
    standing.front().copies = maps_of(setting, model->bounds());
    ContourEngine engine(std::move(standing), engine_settings(setting), structure);
    for (std::int64_t um = 0; um < 12'000; um += 797)
      std::printf("supports, %s, %" PRId64 " um: %016" PRIx64 "\n", setting.name, um,
                  digest_of(engine.mask_at(Nanometers{um * 1000})));
  }
  Contours contours;
  for (std::int64_t um = 0; um < 12'000; um += 797) {
    structure->section_at(Nanometers{um * 1000}, contours);
    std::printf("supports, contours, %" PRId64 " um: %016" PRIx64 ", %zu loops\n", um, digest_of(contours),
                contours.loops.size());
  }
  Digest digest;
  const std::vector<Facet> facets = support_mesh(structure->primitives());
  for (const Facet& facet : facets) {
    for (const Vertex& v : facet.vertices) {
      for (const float coordinate : {v.x, v.y, v.z})
        digest.add(std::uint64_t{std::bit_cast<std::uint32_t>(coordinate)});
    }
  }
  std::printf("supports, %zu facets: %016" PRIx64 "\n", facets.size(), digest.value());
}

// Prints the light of layers whose undersides are dimmed, which depends on exponentials.
void print_dimmed_undersides() {
  const WorkingCurve resin{Micrometers{150}, MillijoulesPerCm2{8}};
  const auto model = std::make_shared<const HeightIndex>(models::gyroid_sphere(8, 5, 24));
  constexpr Nanometers kLayer{50'000};
  const auto layers = static_cast<std::int64_t>(model->bounds().size_z() / in_mm(kLayer));
  for (const Setting& setting : settings()) {
    for (const double memory : {1.0, 0.9}) {
      std::vector<PlateModel> standing(1);
      standing.front().model = model;
      standing.front().copies = maps_of(setting, model->bounds());
      const EngineSettings engine = engine_settings(setting);
      UndersideCure cure{.layers = {},
                         .resin = {.curve = resin, .peel_memory = memory},
                         .mask_budget = std::chrono::minutes{10}};
      for (std::int64_t layer = 1; layer <= layers; ++layer)
        cure.layers.push_back({kLayer * layer, kLayer, resin.dose_for(Micrometers{100})});
      UndersideDimming undersides(standing, nullptr, engine, cure);
      Digest digest;
      std::size_t pixels = 0;
      for (std::size_t layer = 0; layer < cure.layers.size(); ++layer) {
        for (const DimmedPixel& each : undersides.dimmed(layer)) {
          digest.add(std::uint64_t{each.pixel});
          digest.add(each.share);
          ++pixels;
        }
      }
      std::printf("undersides, %s, memory %.1f: %016" PRIx64 ", %zu pixels\n", setting.name, memory,
                  digest.value(), pixels);
    }
  }
}

void print_sines() {
  Digest digest;
  for (int i = -50'000; i <= 50'000; ++i) {
    const auto [sine, cosine] = sine_cosine(i * 0.0123);
    digest.add(sine);
    digest.add(cosine);
  }
  std::printf("sines: %016" PRIx64 "\n", digest.value());
}

// The parts of the output, in order; they are independent of each other.
std::vector<std::function<void()>> parts() {
  std::vector<std::function<void()>> parts{print_sines};
  const Orientation turned{45, 30, 10.1, Scale(1.0)}, scaled{0, 90, -123.456, Scale(0.777)};
  Orientation up;
  up.up = Direction{1, -2, 3.5};
  for (const auto& subjects : {good_models(), bad_models()}) {
    for (const Subject& subject : subjects) {
      parts.emplace_back([=] { print_subject(subject, {}, "as it is", true); });
      // Float's greatest numbers would overflow when rotated.
      if (subject.name == "huge") continue;
      parts.emplace_back([=] { print_subject(subject, turned, "turned", false); });
      parts.emplace_back([=] { print_subject(subject, scaled, "scaled", false); });
      parts.emplace_back([=] { print_subject(subject, up, "up", false); });
    }
  }
  parts.emplace_back(print_supports);
  parts.emplace_back(print_dimmed_undersides);
  return parts;
}

void print_digests(std::string_view argument) {
  const std::vector<std::function<void()>> all = parts();
  if (argument == "--parts") {
    std::printf("%zu\n", all.size());
    return;
  }
  if (!argument.empty()) {
    all.at(std::stoul(std::string(argument)))();
    return;
  }
  for (const std::function<void()>& part : all)
    part();
}

}  // namespace
}  // namespace contourd

int main(int argc, char** argv) {
  try {
    contourd::print_digests(argc > 1 ? argv[1] : "");
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "mask-digests: %s\n", error.what());
    return 70;
  }
}
