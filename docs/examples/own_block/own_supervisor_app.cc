// tenon-guide-dog with a custom supervisor: `own_supervisor_app C1 --set custom.threshold_N=40`

#include <tenon/apps/guide_dog/guide_dog_app.h>

struct StopSupervisorParams {
  double threshold = 50;  // force of the leash that stops the robot [N]
  tenon::Rate rate = tenon::Hz(100);
  void Validate() const { tenon::Demand(threshold > 0, "threshold must be positive"); }
};

// Stops the robot for good at the first pull of the leash.
class StopSupervisor final : public tenon::LeafSystem<StopSupervisorParams> {
 public:
  using LeafSystem::LeafSystem;
  tenon::InputPort<tenon::WalkCommand> command{this, {"command"}};
  tenon::InputPort<tenon::WrenchEstimate> wrench{this, {"wrench"}};
  tenon::Scratch<bool> stopped{this, "stopped", false};
  tenon::OutputPort<tenon::GuideStatus> status{this,
                                               {"status"},
                                               tenon::Sampled{params.rate},
                                               tenon::Uses(wrench, stopped),
                                               &StopSupervisor::CalcStatus};
  tenon::OutputPort<tenon::WalkCommand> walk{
      this, {"walk"}, tenon::Sampled{params.rate}, tenon::Uses(command, status), &StopSupervisor::CalcWalk};

 private:
  tenon::GuideStatus CalcStatus(const tenon::WrenchEstimate& wrench, bool& stopped) const {
    stopped = stopped || wrench.force_W.head<2>().norm() > params.threshold;
    tenon::GuideStatus status;
    status.mode = stopped ? tenon::GuideMode::kStop : tenon::GuideMode::kMove;
    return status;
  }
  tenon::WalkCommand CalcWalk(const tenon::WalkCommand& command, const tenon::GuideStatus& status) const {
    tenon::WalkCommand walk = command;
    if (status.mode == tenon::GuideMode::kStop) walk.gait = tenon::Gait::kStand;
    return walk;
  }
};

struct Keys {
  double threshold_N = 50;
  static tenon::FieldList Fields() { return {{"threshold_N", &Keys::threshold_N}}; }
};

int main(int argc, char** argv) {
  return tenon::apps::GuideDogApp()
      .Customise<Keys>([](tenon::DiagramBuilder& builder, tenon::GuideDog& dog, const Keys& keys) {
        builder.Replace<StopSupervisor>(dog.supervisor, {.threshold = keys.threshold_N});
      })
      .Run(argc, argv);
}
