// tenon-cdpr with a custom controller: `own_controller_app D1 --set controller=pd_feedforward --compare`

#include <tenon/apps/cdpr/cdpr_app.h>

#include <algorithm>
#include <cmath>

struct IntegralPdParams {
  tenon::CablePdParams pd;          // gains and model of the shipped PD
  double integral_N_per_m_s = 100;  // K_i
};

// A PD of the cable lengths with an integral: f = f* + K_p e + K_d e' + K_i ∫ e dt, kept inside the bounds of
// the tension, with the errors e of the lengths and the tensions f* of the reference.
class IntegralPd final : public tenon::LeafSystem<IntegralPdParams> {
 public:
  using LeafSystem::LeafSystem;
  tenon::InputPort<tenon::CableSignals> cables{this, {"cables"}};
  tenon::InputPort<tenon::CdprReference> reference{this, {"reference"}};
  tenon::Scratch<tenon::CableVector> integral{
      this, "integral", tenon::CableVector(tenon::CableVector::Zero(params.pd.robot.num_cables()))};
  tenon::OutputPort<tenon::CableVector> command{this,
                                                {"command", "N"},
                                                tenon::CableVector::Zero(params.pd.robot.num_cables()),
                                                tenon::Sampled{params.pd.rate},
                                                tenon::Uses(cables, reference, integral),
                                                &IntegralPd::CalcCommand};
  tenon::OutputPort<double> largest_error{
      this,
      {"largest_error", "m"},
      tenon::Uses(cables, reference),
      [](const tenon::CableSignals& cables, const tenon::CdprReference& reference) {
        return (cables.length - reference.length).cwiseAbs().maxCoeff();
      }};

 private:
  void CalcCommand(const tenon::CableSignals& cables, const tenon::CdprReference& reference,
                   tenon::CableVector& integral, tenon::CableVector* command) const {
    const auto& [robot, kp, kd, rate] = params.pd;
    integral += rate.period() * (cables.length - reference.length);
    *command = reference.tension + kp * (cables.length - reference.length) +
               kd * (cables.length_rate - reference.length_rate) + params.integral_N_per_m_s * integral;
    robot.LimitTension(command);
  }
};

struct Keys {
  double integral_N_per_m_s = 100;
  static tenon::FieldList Fields() { return {{"integral_N_per_m_s", &Keys::integral_N_per_m_s}}; }
};

int main(int argc, char** argv) {
  return tenon::apps::CdprApp()
      .Customise<Keys>([](tenon::DiagramBuilder& builder, tenon::CdprLoop& loop, const Keys& keys,
                          tenon::apps::Outputs& outputs) {
        tenon::Demand(loop.control.pd != nullptr, "this controller replaces a PD: set controller=pd");
        auto& mine = builder.Replace<IntegralPd>(
            *loop.control.pd, {.pd = loop.control.pd->params, .integral_N_per_m_s = keys.integral_N_per_m_s});
        outputs.Plot("largest error of the lengths", {&mine.largest_error});
        outputs.Figure("length_error_max_m", mine.largest_error, &tenon::apps::Tally::max);
      })
      .Run(argc, argv);
}
