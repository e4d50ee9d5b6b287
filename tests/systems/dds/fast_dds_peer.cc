// A program of another implementation of DDS: sends each message of /NAME back as /NAME_back, until its
// standard input ends, and then prints how many it received and how many of the writer's it missed after the
// first. usage: fast_dds_peer DOMAIN PREFIX

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <ros2PubSubTypes.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

namespace fast = eprosima::fastdds::dds;

struct Echo {
  virtual ~Echo() = default;
  std::string name;
  std::atomic<long> count{0}, first{0}, last{0};  // numbers are those of the writer
};

/// Reads and writes with the QoS that is the default of ROS 2, but a history that loses nothing.
template <class Type>
class EchoOf final : public Echo, public fast::DataReaderListener {
 public:
  EchoOf(fast::DomainParticipant* participant, const std::string& topic) {
    fast::TypeSupport type(new Type);
    type.register_type(participant);
    name = topic;
    auto* in = participant->create_topic(topic, type.get_type_name(), fast::TOPIC_QOS_DEFAULT);
    auto* out = participant->create_topic(topic + "_back", type.get_type_name(), fast::TOPIC_QOS_DEFAULT);
    fast::DataWriterQos writing;
    writing.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
    writing.history().kind = fast::KEEP_ALL_HISTORY_QOS;
    writer_ = participant->create_publisher(fast::PUBLISHER_QOS_DEFAULT)->create_datawriter(out, writing);
    fast::DataReaderQos reading;
    reading.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
    reading.history().kind = fast::KEEP_ALL_HISTORY_QOS;
    participant->create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT)->create_datareader(in, reading, this);
  }
  void on_data_available(fast::DataReader* reader) override {
    typename Type::type message;
    fast::SampleInfo info;
    while (reader->take_next_sample(&message, &info) == ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data) continue;
      last = info.sample_identity.sequence_number().to64long();
      if (++count == 1) first = last.load();
      writer_->write(&message);
    }
  }

 private:
  fast::DataWriter* writer_;
};

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  // The loopback interface has no multicast: the other participants are at the ports of this machine.
  const auto loopback = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  loopback->interfaceWhiteList.push_back("127.0.0.1");
  const int domain = std::atoi(argv[1]);
  fast::DomainParticipantQos qos;
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(loopback);
  for (int i = 0; i < 32; ++i) {
    eprosima::fastrtps::rtps::Locator_t peer;
    eprosima::fastrtps::rtps::IPLocator::setIPv4(peer, "127.0.0.1");
    peer.port = static_cast<std::uint32_t>(7410 + 250 * domain + 2 * i);
    qos.wire_protocol().builtin.initialPeersList.push_back(peer);
  }
  auto* participant = fast::DomainParticipantFactory::get_instance()->create_participant(
      static_cast<fast::DomainId_t>(domain), qos);
  if (participant == nullptr) return 1;
  const std::string prefix = argv[2];
  std::vector<std::unique_ptr<Echo>> echoes;
  const auto add = [&]<class Type>(const char* name, Type*) {
    echoes.push_back(std::make_unique<EchoOf<Type>>(participant, prefix + name));
  };
  add("String", static_cast<std_msgs::msg::StringPubSubType*>(nullptr));
  add("Twist", static_cast<geometry_msgs::msg::TwistPubSubType*>(nullptr));
  add("WrenchStamped", static_cast<geometry_msgs::msg::WrenchStampedPubSubType*>(nullptr));
  add("JointState", static_cast<sensor_msgs::msg::JointStatePubSubType*>(nullptr));
  add("Imu", static_cast<sensor_msgs::msg::ImuPubSubType*>(nullptr));
  add("Joy", static_cast<sensor_msgs::msg::JoyPubSubType*>(nullptr));
  add("Odometry", static_cast<nav_msgs::msg::OdometryPubSubType*>(nullptr));
  add("TFMessage", static_cast<tf2_msgs::msg::TFMessagePubSubType*>(nullptr));
  add("Clock", static_cast<rosgraph_msgs::msg::ClockPubSubType*>(nullptr));
  while (std::getchar() != EOF) {
  }
  for (const auto& echo : echoes)
    std::printf("%s %ld %ld\n", echo->name.c_str(), echo->count.load(),
                echo->count == 0 ? 0 : echo->last - echo->first + 1 - echo->count);
  return 0;
}
