// Fuzz target: any bytes as a file of a model, whatever archive or package it is. The file is refused with
// one readable sentence, or gives finite facets, at most as many as were allowed, or pictures or outlines of
// layers within the memory that was allowed, and masks of the outlines.
#include <sys/mman.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <system_error>
#include <utility>

#include "core/engine/contour_engine.hpp"
#include "core/mask/picture_solid.hpp"
#include "daemon/formats/model_input.hpp"
#include "daemon/formats/sl1_outlines.hpp"
#include "tests/fuzz/demand.hpp"
#include "tests/fuzz/told.hpp"

namespace {

using namespace contourd;
using fuzz::demand;

constexpr std::uint64_t kAllowedFacets = 100'000;

OpenFile file_of(const std::uint8_t* data, std::size_t size) {
  OpenFile file(::fdopen(::memfd_create("input", MFD_CLOEXEC), "w+b"));
  demand(file != nullptr && std::fwrite(data, 1, size, file.get()) == size && std::fflush(file.get()) == 0,
         "the input is not written");
  std::rewind(file.get());
  return file;
}

constexpr std::uint64_t kAllowedBytes = 1'000'000;

void show_outlines(const SlicedArchive& archive, const DisplayGeometry& display) {
  const auto outlines = read_outlines(archive, display, kAllowedBytes, {});
  demand(outlines->layers() == archive.layers() && outlines->bytes() <= kAllowedBytes && outlines->box(),
         "the outlines are not those of the archive");
  PlateModel model{{std::make_shared<const HeightIndex>(box_of(*outlines))},
                   {PixelMap::true_scale(display, {0, 0})}};
  model.outlines = outlines;
  ContourEngine engine({model}, {display});
  for (const std::size_t layer : {std::size_t{0}, outlines->layers() - 1}) {
    MaskBudget budget(MaskBudget::Clock::now() + std::chrono::seconds(1));
    (void)engine.mask_within(outlines->thickness() * static_cast<std::int64_t>(layer), budget);
  }
}

void read_layers(const SlicedArchive& archive) {
  const DisplayGeometry display{Pixels{8}, Pixels{6}, Micrometers{50}};
  if (archive.has_outlines()) return show_outlines(archive, display);
  const auto pictures = archive.read(display, kAllowedBytes, {});
  demand(pictures->layers() == archive.layers() && pictures->bytes() <= kAllowedBytes && pictures->lit(),
         "the pictures are not those of the archive");
}

void read_all(ModelInput& input) {
  if (input.sliced() != nullptr) return read_layers(*input.sliced());
  const bool is_package = input.outline().format == "3mf";
  const Model model = input.read(kAllowedFacets);
  demand(!is_package || model.facets.size() <= kAllowedFacets, "more facets than were allowed");
  for (const Facet& facet : model.facets)
    demand(is_finite(facet), "a coordinate is not finite");
  for (const std::string& warning : model.warnings)
    fuzz::demand_sentence(warning);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    // Both versions of a model, with supports and without, are chosen by one input or another.
    const bool unsupported = size % 2 == 1;
    OpenedModels opened = open_models(ModelSource{file_of(data, size), size, "input", {{}, unsupported}});
    demand(!opened.models.empty() && opened.models.size() <= kMostArchiveModels, "too many models or none");
    for (const std::string& note : opened.notes)
      fuzz::demand_sentence(note);
    for (const OpenedModel& each : opened.models)
      read_all(*each.input);
  } catch (const ModelError& error) {
    fuzz::demand_sentence(error.what());
  }
  return 0;
}
