"""What agents keep of what they saw: one frame's labels, landmarks by place, the contents of the room."""
