#include "hw/drm/drm_report.hpp"

#include "hw/drm/card.hpp"
#include "hw/drm/color.hpp"
#include "hw/drm/crtc_choice.hpp"
#include "hw/drm/crtc_route.hpp"
#include "hw/drm/dumb_buffer.hpp"
#include "hw/drm/master_holder.hpp"
#include "hw/drm/output.hpp"
#include "hw/drm/text_console.hpp"
#include "hw/hardware_error.hpp"

namespace contourd {

DrmReport check_drm_display(const DrmDisplayConfig& config) {
  OutputSearch search = find_output(config);
  if (!search.found) throw HardwareError(search.why_not);
  const Card& card = search.found->card;
  const Connector& connector = search.found->connector;
  const std::string output = connector.name + " of " + card.name();
  const Mode mode = choose_mode(connector.modes, connector.size, config, output);
  const CrtcRoute route = routes_to(card, connector).front();
  check_format(route, config.format, output);

  DrmReport report;
  report.card = card.path();
  report.driver = card.driver();
  report.connector = connector.name;
  report.mode = describe(mode);
  report.formats = describe_formats(route.formats);
  report.vblank = card.has_vblank(route.crtc_id);
  if (const auto console = console_of(card.path())) report.console = console->string();
  if (!card.is_master()) {
    report.in_use = describe_master_holder(card.path());
    return report;
  }
  const ObjectProperties properties(card.fd(), connector.id, DRM_MODE_OBJECT_CONNECTOR);
  report.range_warning = range_warning(connector.name, mode, properties, output);
  const Framebuffer picture(card, config.width, config.height, config.format);
  report.atomic = make_crtc(card, connector, mode, picture.id(), config.legacy)->is_atomic();
  return report;
}

std::string describe(const DrmReport& report) {
  return report.connector + " of " + report.card + " (" + report.driver + "): " + report.mode +
         (report.in_use   ? ", in use: " + *report.in_use
          : report.atomic ? ", atomic"
                          : ", legacy") +
         (report.vblank ? "" : ", no vblank: presentation times are the driver's") +
         "; formats: " + report.formats +
         (report.console ? "; the text console " + *report.console + " is on this card" : "") +
         (report.range_warning ? "; " + *report.range_warning : "");
}

}  // namespace contourd
