"""People's texts of the official release in the reconstructed city: are they true there, and can they be followed?"""
