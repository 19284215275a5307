#include "daemon/formats/threemf_side_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>

#include "core/model/model.hpp"
#include "daemon/formats/xml_reader.hpp"

namespace contourd {
namespace {

constexpr std::size_t kMostNoted = 100'000;  // volumes and components

struct KindWord {
  std::string_view word, kind;
};

// Values of "volume_type" (PrusaSlicer, Model.cpp) and of "subtype" (Bambu Studio, bbs_3mf.cpp).
constexpr std::array kKinds{KindWord{"ParameterModifier", "modifier"},
                            KindWord{"NegativeVolume", "negative part"},
                            KindWord{"SupportEnforcer", "support enforcer"},
                            KindWord{"SupportBlocker", "support blocker"},
                            KindWord{"modifier_part", "modifier"},
                            KindWord{"negative_part", "negative part"},
                            KindWord{"support_enforcer", "support enforcer"},
                            KindWord{"support_blocker", "support blocker"}};

// Returns the kind for the word; empty for a part of the model, and for words that are unknown.
std::string kind_of(std::string_view word) {
  const auto* const found = std::ranges::find(kKinds, word, &KindWord::word);
  return found == kKinds.end() ? "" : std::string(found->kind);
}

std::uint32_t number_of(const XmlAttributes& attributes, const char* name) {
  const std::string_view text = attributes.text(name);
  std::uint32_t number = 0;
  const auto [after, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || after != text.data() + text.size())
    throw ModelError(fmt::format("{} is not a number: export the model again", name));
  return number;
}

class SideFileReader : public XmlHandler {
 public:
  void open(std::string_view name, const XmlAttributes& attributes) override {
    if (name == "object") {
      object_ = number_of(attributes, "id");
    } else if (name == "volume") {
      volume_ = {number_of(attributes, "firstid"), number_of(attributes, "lastid"), ""};
    } else if (name == "part") {
      const std::string kind = kind_of(attributes.text("subtype"));
      if (!kind.empty() && may_note()) side_file_.components[{object_, number_of(attributes, "id")}] = kind;
    } else if (name == "metadata" && attributes.text("type") == "volume") {
      const std::string_view key = attributes.text("key"), value = attributes.text("value");
      if (key == "volume_type") volume_.kind = kind_of(value);
      if (key == "modifier" && value == "1") volume_.kind = "modifier";  // before PrusaSlicer 2.0
    }
  }

  void close(std::string_view name) override {
    if (name == "volume" && !volume_.kind.empty() && may_note())
      side_file_.volumes[object_].push_back(volume_);
  }

  ThreeMfSideFile take() { return std::move(side_file_); }

 private:
  bool may_note() {
    if (++noted_ <= kMostNoted) return true;
    throw ModelError(fmt::format("it names more than {} modifiers", kMostNoted));
  }

  ThreeMfSideFile side_file_;
  std::uint32_t object_ = 0;
  ThreeMfVolume volume_;
  std::size_t noted_ = 0;
};

}  // namespace

ThreeMfSideFile read_threemf_side_file(ByteStream& stream, const std::string& name) {
  SideFileReader reader;
  read_xml(stream, reader, name);
  return reader.take();
}

}  // namespace contourd
