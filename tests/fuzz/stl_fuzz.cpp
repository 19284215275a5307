// Fuzz target: any bytes as an STL file. It is refused with an ModelError of one sentence, or gives facets of
// finite numbers, which read back the same from a file written with them.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "core/formats/model_reader.hpp"
#include "tests/models/models.hpp"

namespace {

using namespace contourd;

void demand(bool condition, const char* what) {
  if (condition) return;
  std::fprintf(stderr, "broken: %s\n", what);
  std::abort();
}

bool same(const std::vector<Facet>& a, const std::vector<Facet>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Facet)) == 0);
}

void check(const Model& model, std::size_t bytes) {
  // The shortest facet is "facet vertex 0 0 0 vertex 0 0 0 ..." or 50 bytes: no file holds more than it can.
  demand(model.facets.size() <= bytes / 18, "more facets than the file has room for");
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
    check(read_model(std::as_bytes(std::span(data, size))), size);
  } catch (const ModelError& error) {
    const std::string what = error.what();
    demand(!what.empty() && what.find('\n') == std::string::npos, "a refusal is not one sentence");
  }
  return 0;
}
