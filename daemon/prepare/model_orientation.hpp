// Which way up a job's model is printed when its ticket leaves that to contourd. Thread-safe (no shared
// state).
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <stop_token>
#include <string>

#include "core/orientation/orientation_choice.hpp"
#include "daemon/config/job_ticket.hpp"
#include "hw/clock.hpp"

namespace contourd {

struct ModelOrientation {
  OrientationPreset preset = OrientationPreset::Auto;
  OrientationChoice choice;
  Duration took{};
};

// What holds for all models of a job, beside what one's ticket says.
struct OrientationLimits {
  BuildSize build;
  Scale shrinkage;             // that makes good the resin's
  OrientationWeights weights;  // the resin's
  Millimeters lift{};          // 0 where there are no supports
  Millimeters bridge{1.5};
};

// Blocks, for a second for a million facets. Nothing when `stop` was asked for meanwhile. A model that is to
// fill the display is rated as large as its file has it. REQUIRES: a ticket that leaves it to contourd, at
// least one facet.
[[nodiscard]] std::optional<ModelOrientation> find_orientation(std::span<const Facet> facets,
                                                               const ModelTicket& ticket,
                                                               const OrientationLimits& limits,
                                                               const std::stop_token& stop = {});

// For a person: "0.35, -0.66, 0.66 points up (clean): about 10 contacts, 0.25 ml of supports, 35.43 mm high;
// as drawn about 26 contacts, ...".
[[nodiscard]] std::string describe(const ModelOrientation& orientation);
// "about 10 contacts, 0.25 ml of supports, 35.43 mm high, 287 mm2 at most", and what else is to be said.
[[nodiscard]] std::string describe(const OrientationFigures& figures);
// "0.354, -0.661, 0.661".
[[nodiscard]] std::string text_of(const Direction& up);

// The chosen direction's and the best others' figures.
inline constexpr std::size_t kAlternativesTold = 8;
[[nodiscard]] std::span<const OrientationFigures> told_of(const OrientationChoice& choice);
[[nodiscard]] nlohmann::ordered_json orientation_json(const ModelOrientation& orientation);

}  // namespace contourd
