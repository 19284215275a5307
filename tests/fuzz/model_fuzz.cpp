// Fuzz target: any bytes as a model file of the core's formats. The file is refused with a ModelError of one
// sentence, or gives finite facets, at most as many as its outline says, which read back the same from an STL
// file written with them.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "core/formats/model_reader.hpp"
#include "tests/fuzz/demand.hpp"
#include "tests/models/models.hpp"

namespace {

using namespace contourd;
using fuzz::demand;

bool same(const std::vector<Facet>& a, const std::vector<Facet>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Facet)) == 0);
}

std::uint64_t most_facets(std::span<const std::byte> bytes) {
  return outline_of_model({bytes.size(), bytes.first(std::min(bytes.size(), kSniffBytes))}).most_facets;
}

void check(const Model& model, std::span<const std::byte> bytes) {
  demand(model.facets.size() <= most_facets(bytes), "more facets than the outline says");
  for (const Facet& facet : model.facets) {
    for (const Vertex& v : facet.vertices)
      demand(std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z), "a coordinate is not finite");
  }
  if (model.facets.empty()) return;
  demand(same(read_model(models::to_binary_stl(model.facets)).facets, model.facets),
         "binary does not read back");
  const std::string text = models::to_ascii_stl(model.facets);
  demand(same(read_model(std::as_bytes(std::span(text))).facets, model.facets), "ASCII does not read back");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const auto bytes = std::as_bytes(std::span(data, size));
    check(read_model(bytes), bytes);
  } catch (const ModelError& error) {
    const std::string what = error.what();
    demand(!what.empty() && what.find('\n') == std::string::npos, "a refusal is not one sentence");
  }
  return 0;
}
