// Leads supports from the tips' joints down to the plate along branches that merge. Of all open ends, the two
// that save the most resin by meeting are joined first; an end without a straight path down continues around
// the model to its next bend and can meet others there. Not thread-safe. Deterministic.
//
// Bounded: an end is compared with its kPartners nearest; there are at most twice as many nodes as joints and
// bends of the paths.
#pragma once

#include <cstdint>
#include <optional>
#include <queue>
#include <stop_token>
#include <vector>

#include "core/clearance/clearance_field.hpp"
#include "core/clearance/support_path_field.hpp"
#include "core/routing/support_tree.hpp"
#include "core/support/support_settings.hpp"

namespace contourd {

class SupportRouting {
 public:
  // `field` and `paths` must outlive the object.
  SupportRouting(const ClearanceField& field, const SupportPathField& paths, const SupportSettings& settings);

  // Adds a tip that holds contact number `contact`.
  void add(SupportTip tip, std::uint32_t contact, double load_mm2);

  // Leads all added tips down. The tree is unusable if `stop` was requested.
  [[nodiscard]] SupportTree lead_down(const std::stop_token& stop);

 private:
  static constexpr std::size_t kPartners = 12;

  // The lower end of an unfinished branch, and the path on which it continues.
  struct OpenEnd {
    std::uint32_t node;
    SupportPath path;
    bool open = true;
  };
  // Two ends that might meet; `rank` selects one of the places where they can.
  struct Pair {
    double saved_mm3;
    std::uint32_t one, other;
    std::uint32_t rank;
    bool operator<(const Pair& pair) const;
  };
  struct Meeting {
    double saved_mm3;
    PlatePoint place;
  };

  [[nodiscard]] const SupportNode& node_of(std::uint32_t end) const;
  void open(std::uint32_t node, SupportPath path);
  void look_for_partners(std::uint32_t end);
  void push_pair(std::uint32_t one, std::uint32_t other, std::uint32_t rank);
  [[nodiscard]] std::vector<Meeting> meetings_of(std::uint32_t one, std::uint32_t other) const;
  [[nodiscard]] double resin_of(double load_mm2, double length_mm) const;
  [[nodiscard]] double resin_below(double load_mm2, double length_mm) const;
  [[nodiscard]] double width_of(std::uint32_t end, const PlatePoint& to) const;
  [[nodiscard]] bool meet(const Pair& pair, const PlatePoint& place);
  void join(std::uint32_t from, std::uint32_t into);
  [[nodiscard]] std::optional<std::uint32_t> next_to_go_on() const;
  void go_on(std::uint32_t end);
  void end(OpenEnd& end);
  void add_below(std::uint32_t node, const PlatePoint& place, double radius_mm);

  const ClearanceField& field_;
  const SupportPathField& paths_;
  SupportSettings settings_;
  double foot_mm3_;
  SupportTree tree_;
  std::vector<OpenEnd> ends_;
  std::priority_queue<Pair> pairs_;
};

}  // namespace contourd
