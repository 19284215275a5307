#include "hw/drm/display_look.hpp"

#include <exception>
#include <utility>

#include "hw/drm/text_console.hpp"

namespace contourd {

DisplayLook relit(std::shared_ptr<Output> output, const DrmDisplayConfig& config) {
  DisplayLook look{.output = std::move(output)};
  try {
    look.is_back = look.output->relight(config);
    if (look.is_back) look.console_warning = keep_console_dark(look.output->card().path());
  } catch (const std::exception& error) {
    look.refusal = error.what();
    look.output->turn_off();
  }
  return look;
}

DisplayLook found_anywhere(const DrmDisplayConfig& config) {
  OutputSearch search;
  try {
    search = find_output(config);
  } catch (const std::exception&) {
    return {};
  }
  if (!search.found) return {};
  try {
    return opened(std::move(*search.found), config);
  } catch (const std::exception& error) {
    return {.output = nullptr, .is_back = false, .refusal = error.what()};
  }
}

DisplayLook opened(FoundOutput found, const DrmDisplayConfig& config) {
  DisplayLook look;
  look.console_warning = keep_console_dark(found.card.path());
  look.output = std::make_shared<Output>(std::move(found.card), found.connector, config);
  look.is_back = true;
  return look;
}

}  // namespace contourd
