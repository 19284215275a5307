// Chooses which way up a job's model is printed if its ticket leaves that to contourd. Thread-safe (no shared
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

// The orientation chosen for a model.
struct ModelOrientation {
  OrientationPreset preset = OrientationPreset::Auto;
  OrientationChoice choice;
  Duration took{};  // by the search
};

// The limits and weights for all models of a job.
struct OrientationLimits {
  BuildSize build;
  Scale shrinkage;                // factors that compensate the resin's shrinkage
  OrientationWeights weights;     // the resin's
  SupportSettings supports{};     // the resin's; with a lift of 0 if there are no supports
  bool keep_own_supports = true;  // see OrientationRequest
};

// Finds the best orientation for the model; nullopt if `stop` was requested. A model with `fit` is rated at
// the size in its file. Blocks: see choose_orientation(). REQUIRES: the ticket leaves the
// orientation to contourd; at least one facet.
[[nodiscard]] std::optional<ModelOrientation> find_orientation(std::span<const Facet> facets,
                                                               const ModelTicket& ticket,
                                                               const OrientationLimits& limits,
                                                               const std::stop_token& stop = {});

// Returns a sentence: "0.354, -0.661, 0.661 points up (clean): about 10 contacts, 0.25 ml of supports, 35.43
// mm high, largest layer 287 mm²; as drawn: about 26 contacts, ...".
[[nodiscard]] std::string describe(const ModelOrientation& orientation);
// Returns "about 10 contacts, 0.25 ml of supports, 35.43 mm high, largest layer 287 mm²" and, if they apply,
// that the model stands by itself, touches surfaces to be kept clean or does not fit.
[[nodiscard]] std::string describe(const OrientationFigures& figures);
// Returns the direction, rounded to thousandths: "0.354, -0.661, 0.661".
[[nodiscard]] std::string text_of(const Direction& up);

inline constexpr std::size_t kMaxReported = 8;
// Returns the figures of the chosen direction and of the next best ones, at most kMaxReported in all.
[[nodiscard]] std::span<const OrientationFigures> reported(const OrientationChoice& choice);
// Returns the choice with the figures of reported().
[[nodiscard]] nlohmann::ordered_json orientation_json(const ModelOrientation& orientation);

}  // namespace contourd
