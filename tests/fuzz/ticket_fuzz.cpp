// Fuzz target: any bytes as a model's ticket or a plate's (first byte t or p). The ticket is refused in
// printable sentences, or is possible: bounded figures, no two that exclude each other, and no file outside
// the plate's folder.
#include <cmath>
#include <cstdint>
#include <variant>

#include "daemon/config/job_ticket.hpp"
#include "tests/fuzz/told.hpp"
#include "tests/temporary_folder.hpp"

namespace contourd::fuzz {
namespace {

void check(const DrainHole& hole) {
  const Direction& inwards = hole.inwards;
  const double length = std::hypot(inwards.x, inwards.y, inwards.z);
  demand(std::isfinite(length) && length > 0, "a hole without a direction");
  demand(hole.diameter_mm > 0 && hole.diameter_mm <= 1e4 && hole.depth_mm > 0 && hole.depth_mm <= 1e5,
         "a hole without a bound");
  for (const double place : {hole.x_mm, hole.y_mm, hole.z_mm})
    demand(std::fabs(place) <= 1e5, "a hole's place without a bound");
}

bool is_plain_name(const std::string& file) {
  return !file.empty() && file.front() != '.' && file.find('/') == std::string::npos &&
         file.find('\0') == std::string::npos;
}

void check(const ModelTicket& model, bool of_plate) {
  demand(of_plate ? is_plain_name(model.file) : model.file.empty(), "a model lies elsewhere");
  demand(model.copies >= 1 && model.copies <= 1000, "copies without a bound");
  demand(!model.up || model.rotation == RotationDegrees{}, "a model has two orientations");
  demand(!model.scale || !model.fit, "a model has two sizes");
  for (const double angle : {model.rotation.x, model.rotation.y, model.rotation.z})
    demand(std::fabs(angle) <= 360, "an angle without a bound");
  if (model.up) {
    const double length = std::hypot(model.up->x, model.up->y, model.up->z);
    demand(std::isfinite(length) && length > 0, "no direction");
  }
  if (model.scale) {
    for (const double factor : {model.scale->x, model.scale->y, model.scale->z})
      demand(factor > 0 && factor <= 1000, "a factor without a bound");
  }
  if (model.position) {
    demand(std::fabs(model.position->x.count()) <= 1000 && std::fabs(model.position->y.count()) <= 1000,
           "a place without a bound");
  }
}

void check_drain(const ModelTicket& model) {
  demand(model.drain.size() <= 16, "holes without a bound");
  for (const DrainHole& hole : model.drain)
    check(hole);
}

void check_kept_clean(const ModelTicket& model) {
  if (!model.orientation) return;
  for (const KeepClean& part : model.orientation->keep_clean) {
    if (const auto* const box = std::get_if<KeepCleanBox>(&part)) {
      demand(box->least.x <= box->most.x && box->least.y <= box->most.y && box->least.z <= box->most.z,
             "a box is turned inside out");
    } else {
      demand(std::get<Direction>(part) != Direction{0, 0, 0}, "a part to keep clean has no direction");
    }
  }
}

void check(const JobTicket& ticket, bool of_plate) {
  demand(!ticket.resin || is_plain_name(*ticket.resin), "a resin's name leads out of its folder");
  demand(!ticket.layer_height || ticket.layer_height->count() > 0, "layers without a height");
  demand(!ticket.layer_height || !ticket.adaptive, "a job has two kinds of layers");
  if (ticket.adaptive) {
    const auto& [cusp, thinnest, thickest] = *ticket.adaptive;
    demand(cusp.count() > 0, "a cusp without a height");
    demand(!thinnest || !thickest || *thinnest <= *thickest, "the thinnest layer is the thicker");
  }
  demand(of_plate ? !ticket.models.empty() : ticket.models.size() == 1, "a ticket without its model");
  for (const ModelTicket& model : ticket.models) {
    check(model, of_plate);
    check_drain(model);
    check_kept_clean(model);
  }
}

}  // namespace
}  // namespace contourd::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace contourd;
  static const testing::TemporaryFolder folder;
  if (size == 0 || (data[0] != 't' && data[0] != 'p')) return 0;
  const bool of_plate = data[0] == 'p';
  const auto file = folder.write("fuzzed.json", {reinterpret_cast<const char*>(data) + 1, size - 1});
  try {
    fuzz::check(of_plate ? load_plate_ticket(file, Links::Refuse) : load_job_ticket(file, Links::Refuse),
                of_plate);
  } catch (const ConfigError& error) {
    fuzz::demand_told(error);
  }
  return 0;
}
