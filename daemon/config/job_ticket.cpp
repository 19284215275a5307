#include "daemon/config/job_ticket.hpp"

#include "daemon/config/json_document.hpp"
#include "daemon/config/json_schema.hpp"
#include "daemon/config/json_section.hpp"

namespace contourd {
namespace {

void check_rules(JsonDocument& document) {
  // By now `fit` is there, if the ticket is an object at all.
  if (document.sound_number("/scale") && document.value().at("fit") == true) {
    document.add_violation("/scale", "a ticket has either scale or fit, not both");
  }
}

JobTicket read_ticket(const JsonSection& root) {
  const JsonSection rotation = root.section("rotation_deg");
  const JsonSection position = root.section("position_mm");
  JobTicket ticket;
  if (root.has("resin")) ticket.resin = root.text("resin");
  if (root.has("layer_height_um")) ticket.layer_height = root.length("layer_height_um");
  ticket.rotation = {rotation.number("x"), rotation.number("y"), rotation.number("z")};
  if (root.has("scale")) ticket.scale = root.number("scale");
  ticket.fit = root.boolean("fit");
  ticket.position = {Millimeters{position.number("x")}, Millimeters{position.number("y")}};
  ticket.copies = root.integer<int>("copies");
  ticket.cracks = root.text("cracks") == "refuse" ? CrackPolicy::Refuse : CrackPolicy::Repair;
  return ticket;
}

}  // namespace

JobTicket load_job_ticket(const std::filesystem::path& path) {
  JsonDocument document = JsonDocument::from_file(path);
  ticket_schema().check(document);
  check_rules(document);
  document.throw_if_violated();
  return read_ticket(JsonSection(document));
}

}  // namespace contourd
