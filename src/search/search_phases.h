#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "search/candidates.h"
#include "search/model_search.h"

namespace armtrue {

/// Smallest fall of EBIC for which one effect replaces another.
inline constexpr double kMinFallToExchange = 2.0;

/// One search: forward steps, revisions between them, and the last refinements.
class ModelSearch {
 public:
  ModelSearch(const Robot& robot, const Campaign& campaign, const Catalogue& catalogue,
              const TraceOptions& options)
      : options_(options),
        campaign_(campaign),
        result_{EffectModel(robot, campaign, catalogue, options), {}, {}, {}, 0, 1, false, {}},
        model_(result_.model) {
    result_.stages.push_back(model_.fit());
  }
  ModelSearch(const ModelSearch&) = delete;  // model_ refers to result_
  ModelSearch& operator=(const ModelSearch&) = delete;

  void run();
  SearchResult take() { return std::move(result_); }

 private:
  enum class KnownCauses { stay, give_way };  // to what no catalogue names

  void find_effects();
  bool drop_half_shown();
  void end_last_stage();

  // Forward (model_search.cc).
  bool step();
  bool add_event();
  bool add_by_least_squares();
  void rank(const std::vector<CandidateScore>& scores, const std::vector<int>& order);
  void note_rest();
  void judge_rest();
  void begin_with(const Effect& effect);
  bool is_new_model();
  bool may_enter(const Candidate& candidate) const;
  bool is_half_shown(int k);
  bool may_be_knock(int k);
  const std::vector<Candidate>& candidates() const { return model_.scan().candidates(); }

  // Revisions (search_revisions.cc).
  bool revise(KnownCauses known_causes);
  struct Revision {
    int effect;                      // of the chosen ones
    std::optional<Candidate> other;  // in its place; none: the effect is dropped
  };
  bool was_taken_back(const Effect& a, const Effect& b) const;
  bool leads_to(const Revision& revision, const std::vector<Candidate>& chosen) const;
  std::optional<Revision> best_revision(KnownCauses known_causes);
  std::optional<EffectModel::Refined> cycle_in_place_of(int curve, double least,
                                                        const ProjectedCandidates::Place& place);
  std::optional<int> better_than(double least, const std::vector<CandidateScore>& scores) const;
  bool merge_into_spline(size_t least);
  bool part_into_steps();

  // At the end (search_end.cc).
  void settle_inner_values();
  void settle_place_of(int chosen);
  void settle_inner_values(const std::function<bool(const Candidate&)>& asked, double least);
  void drop_idle();
  void drop_by_refit();
  void share_in_station();
  void split_families();
  void judge_members(const std::string& family);
  void add_those_that_share(std::vector<int>& ascending);
  void hold_family_of_most_arms();
  bool add_beside_found(Candidate family);
  Eigen::VectorXd errors_left_out(const Robot& robot) const;

  const TraceOptions& options_;
  const Campaign& campaign_;
  SearchResult result_;
  EffectModel& model_;
  int merges_ = 0;
  bool details_ = false;         // whether they may enter: only when nothing simpler is left
  bool failed_at_gate_ = false;  // whether the last step did, and p of its best is known
  std::set<std::multiset<std::string>> seen_;
  // Families that were half shown beside the present model, or beside all that was found.
  std::set<std::string> barred_, rejected_;
  std::set<std::string> parted_;  // parameters whose curve of time was compared with steps
  std::set<std::string> shared_;  // families whose members share what was found of one
  // Pairs of forms that changed places and changed back. They may do so again once nothing is to be
  // added, when known causes give way.
  std::vector<std::array<Effect, 2>> taken_back_;
};

}  // namespace armtrue
