// Fuzz target: any bytes as a file of a model, whatever archive or package it is. The file is refused with
// one readable sentence, or gives finite facets, at most as many as were allowed, or pictures of layers
// within the memory that was allowed.
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <system_error>
#include <utility>

#include "daemon/formats/model_input.hpp"
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

void read_pictures(const Sl1Archive& archive) {
  constexpr std::uint64_t kAllowedBytes = 1'000'000;
  const DisplayGeometry display{Pixels{8}, Pixels{6}, Micrometers{50}};
  const auto pictures = archive.read(display, kAllowedBytes, {});
  demand(pictures->layers() == archive.layers() && pictures->bytes() <= kAllowedBytes && pictures->lit(),
         "the pictures are not those of the archive");
}

void read_all(ModelInput& input) {
  if (input.sliced() != nullptr) return read_pictures(*input.sliced());
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
