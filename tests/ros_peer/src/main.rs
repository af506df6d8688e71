fn main() { println!("{}", hiroz_msgs::ros::nav_msgs::Odometry::default().child_frame_id.len()); }
