#include "hw/drm/display_probe.hpp"

#include <exception>
#include <utility>

#include "hw/drm/text_console.hpp"

namespace contourd {

DisplayProbe restored(std::shared_ptr<Output> output, const DrmDisplayConfig& config) {
  DisplayProbe probe{.output = std::move(output)};
  try {
    probe.is_back = probe.output->restore(config);
    if (probe.is_back) probe.console_warning = keep_console_dark(probe.output->card().path());
  } catch (const std::exception& error) {
    probe.refusal = error.what();
    probe.output->turn_off();
  }
  return probe;
}

DisplayProbe probe_all(const DrmDisplayConfig& config) {
  OutputSearch search;
  try {
    search = find_output(config);
  } catch (const std::exception&) {
    return {};
  }
  if (!search.found) return {};
  try {
    return open_display(std::move(*search.found), config);
  } catch (const std::exception& error) {
    return {.output = nullptr, .is_back = false, .refusal = error.what()};
  }
}

DisplayProbe open_display(FoundOutput found, const DrmDisplayConfig& config) {
  DisplayProbe probe;
  probe.console_warning = keep_console_dark(found.card.path());
  probe.output = std::make_shared<Output>(std::move(found.card), found.connector, config);
  probe.is_back = true;
  return probe;
}

}  // namespace contourd
