#include "daemon/formats/model_names.hpp"

#include <algorithm>
#include <array>

namespace contourd {
namespace {

constexpr std::array<std::string_view, 12> kModelExtensions{".stl",    ".stl.gz", ".3mf",     ".obj",
                                                            ".obj.gz", ".amf",    ".amf.gz",  ".zip",
                                                            ".sl1",    ".sl1s",   ".sl1_svg", ".nanodlp"};

bool ends_with_word(std::string_view text, std::string_view lower_case) {
  if (text.size() <= lower_case.size()) return false;
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  return std::ranges::equal(text.substr(text.size() - lower_case.size()), lower_case, {}, lower);
}

}  // namespace

std::span<const std::string_view> model_extensions() {
  return kModelExtensions;
}

std::string_view model_extension(std::string_view file_name) {
  const std::string_view name = file_name.substr(file_name.rfind('/') + 1);
  const auto* const found = std::ranges::find_if(
      kModelExtensions, [&](std::string_view extension) { return ends_with_word(name, extension); });
  return found == kModelExtensions.end() ? "" : *found;
}

std::string model_stem(std::string_view file_name) {
  return std::string(file_name.substr(0, file_name.size() - model_extension(file_name).size()));
}

std::string model_extensions_text() {
  std::string text;
  for (const std::string_view extension : kModelExtensions) {
    if (!text.empty()) text += extension == kModelExtensions.back() ? " or " : ", ";
    text += extension;
  }
  return text;
}

}  // namespace contourd
