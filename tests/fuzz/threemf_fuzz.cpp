// Fuzz target: any bytes as a model file of a 3MF package, with another one as a side file after a NUL. They
// are refused with one readable sentence, or give finite facets, at most as many as were allowed.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <utility>

#include "daemon/formats/threemf_facets.hpp"
#include "tests/fuzz/demand.hpp"
#include "tests/fuzz/told.hpp"

namespace {

using namespace contourd;
using fuzz::demand;

constexpr std::uint64_t kAllowedFacets = 100'000;

class TextStream : public ByteStream {
 public:
  explicit TextStream(std::string_view text) : text_(text) {}
  [[nodiscard]] std::uint64_t bytes() const override { return text_.size(); }
  std::size_t read_some(std::span<std::byte> into) override {
    const std::size_t bytes = std::min(into.size(), text_.size());
    std::memcpy(into.data(), text_.data(), bytes);
    text_.remove_prefix(bytes);
    return bytes;
  }

 private:
  std::string_view text_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view all(reinterpret_cast<const char*>(data), size);
  const std::string_view text = all.substr(0, all.find('\0'));
  try {
    TextStream stream(text);
    ThreeMfModel model{{}, "root"};
    model.parts.emplace("root", read_threemf_part(stream, "the model", ThreeMfRoot::Yes));
    if (text.size() < all.size()) {
      TextStream side_stream(all.substr(text.size() + 1));
      (void)leave_out(model, read_threemf_side_file(side_stream, "the side file"));
    }
    const Model made = facets_of(model, kAllowedFacets);
    demand(made.facets.size() <= kAllowedFacets, "more facets than were allowed");
    for (const Facet& facet : made.facets)
      demand(is_finite(facet), "a coordinate is not finite");
  } catch (const ModelError& error) {
    fuzz::demand_sentence(error.what());
  }
  return 0;
}
